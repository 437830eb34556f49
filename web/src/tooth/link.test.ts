import assert from "node:assert/strict";
import { test } from "node:test";
import { StudioLink, type StudioPort } from "./link";
import type { ScreenState, StudioAsk } from "./messages";

test("the first screen has the canvas that was made ready ahead, each other one its own", (t) => {
  const asked: StudioAsk[] = [];
  const port: StudioPort = {
    postMessage: (ask) => asked.push(ask),
    onmessage: null,
    onerror: null,
    terminate: () => undefined,
  };
  const own = { transferControlToOffscreen: () => "another" };
  Object.assign(globalThis, { document: { createElement: () => own } });
  t.after(() => {
    Reflect.deleteProperty(globalThis, "document");
  });
  const ahead = {} as HTMLCanvasElement;
  const link = new StudioLink(port, ahead);
  const nothing = () => undefined;
  const opened = () => link.screen(link.film(nothing), {} as ScreenState, undefined, nothing, nothing)[1];
  assert.equal(opened(), ahead);
  assert.equal(opened(), own);
  assert.deepEqual(
    asked.map((ask) => ("ahead" in ask ? ask.ahead : "screen" in ask && ask.message.ask)),
    ["open", "another", "open"],
  );
});
