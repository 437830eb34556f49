import type { StudioAsk, StudioTold } from "./messages";
import { drawsSlowly } from "./scene/renderer";
import { Studio } from "./studio";

// What runs in the worker that reads and draws teeth; a script of its own (scripts/build.mjs).

// What the build puts in: the address of the script of opened.ts.
declare const kOpenedAddress: string;

interface Scope {
  onmessage: ((event: MessageEvent<StudioAsk>) => void) | null;
  postMessage(message: StudioTold, transfer: readonly Transferable[]): void;
}
const scope = globalThis as unknown as Scope;

// A timer would wait for some milliseconds; a message of its own comes after those that wait
// already.
const channel = new MessageChannel();
const resumes: (() => void)[] = [];
channel.port1.onmessage = () => resumes.shift()?.();
const pause = () =>
  new Promise<void>((resolve) => {
    resumes.push(resolve);
    channel.port2.postMessage(undefined);
  });

drawsSlowly(); // asks the browser for its graphics while the tooth is on its way
const studio = new Studio((told, transfer = []) => scope.postMessage(told, transfer), {
  pause,
  opener: () => import(kOpenedAddress),
});
scope.onmessage = ({ data }) => studio.take(data);
