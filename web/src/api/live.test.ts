import assert from "node:assert/strict";
import { test } from "node:test";
import { checkLiveEvent, forceSize, watchAttempt } from "./live";

class FakeStream extends EventTarget {
  readyState = 1;
  closed = 0;
  close() {
    this.readyState = 2;
    ++this.closed;
  }
  say(type: string, data?: string) {
    this.dispatchEvent(Object.assign(new Event(type), { data }));
  }
}

function watching() {
  const stream = new FakeStream();
  const said: string[] = [];
  const stop = watchAttempt(
    "a/1",
    {
      onRows: (rows) => said.push(`rows ${rows.length}`),
      onEnd: () => said.push("end"),
      onProblem: (message) => said.push(message),
    },
    (address) => {
      said.push(address);
      return stream as unknown as EventSource;
    },
  );
  return { stream, said, stop };
}

test("rows come in millimetres and newtons", () => {
  const rows = checkLiveEvent('{"tick":32,"rows":[[16,1000,-2000,500,0,0,0,0],[32,1000,-2000,500,300,0,-400,16]]}');
  assert.ok(rows.ok);
  assert.deepEqual(rows.value[0]?.anchorMm, [1, -2, 0.5]);
  assert.equal(forceSize(rows.value[1]!), 0.5);
});

test("text that is no event is refused with a reason", () => {
  const cases = [
    "",
    "null",
    "[]",
    '{"rows":3}',
    '{"rows":[[1,2,3]]}',
    '{"rows":[[1,2,3,4,5,6,7,null]]}',
    '{"rows":[[2,0,0,0,0,0,0,0],[2,0,0,0,0,0,0,0]]}',
  ];
  for (const text of cases) {
    const result = checkLiveEvent(text);
    assert.ok(!result.ok && result.error.length > 5, text);
  }
});

test("a watched attempt reports rows, a lost connection and its end, after which the stream is closed", () => {
  const { stream, said } = watching();
  stream.say("ticks", '{"tick":1,"rows":[[1,0,0,0,0,0,0,0]]}');
  stream.say("ticks", "no");
  stream.say("error");
  stream.say("end");
  assert.equal(said[0], "/api/v1/attempts/a%2F1/live");
  assert.equal(said[1], "rows 1");
  assert.match(said[2]!, /not understood/);
  assert.match(said[3]!, /trying again/);
  assert.equal(said[4], "end");
  assert.equal(stream.closed, 1);
});

test("a stream that the server refuses reports that and is not tried again; stopping closes it", () => {
  const { stream, said, stop } = watching();
  stream.readyState = 2;
  stream.say("error");
  assert.match(said[1]!, /not being made now/);
  stop();
  assert.equal(stream.closed, 1);
});
