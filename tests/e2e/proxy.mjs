// A small proxy before the real server: keeps one address while the server behind it changes, tells whether anybody
// has changed something, and plays the faults of a server that the real one cannot be asked for.
import { createServer, request as ask } from "node:http";

// { url, target, changed, faults, hold, close }. `target`: address of the server behind. `changed`: whether a request that
// changes something passed since it was set to false; a sign-in does not count. `faults`: functions of (request,
// response), asked in turn; the one that returns true has answered, or will. `hold()`: requests wait until the function that it returns is called,
// as while the server is started anew.
export async function startProxy() {
  const proxy = { target: undefined, changed: false, faults: [] };
  let held = Promise.resolve();
  proxy.hold = () => {
    let release;
    held = new Promise((resolve) => {
      release = resolve;
    });
    return release;
  };
  const server = createServer((request, response) => {
    if (!["GET", "HEAD"].includes(request.method) && request.url !== "/api/v1/session") proxy.changed = true;
    if (!proxy.faults.some((fault) => fault(request, response)))
      void held.then(() => response.destroyed || passOn(proxy.target, request, response));
  });
  await new Promise((resolve, reject) => server.once("error", reject).listen(0, "127.0.0.1", resolve));
  proxy.url = `http://127.0.0.1:${server.address().port}`;
  proxy.close = () =>
    new Promise((resolve) => {
      server.closeAllConnections();
      server.close(resolve);
    });
  return proxy;
}

function passOn(target, request, response) {
  const to = new URL(request.url, target);
  // Its own connection: one that was kept may be one that the server has just closed.
  const onward = ask(to, { method: request.method, headers: request.headers, agent: false }, (answer) => {
    response.writeHead(answer.statusCode, answer.rawHeaders);
    answer.pipe(response);
    answer.once("error", () => response.destroy());
  });
  // As a server that is away: the connection ends without an answer.
  onward.once("error", () => response.destroy());
  response.once("close", () => onward.destroy());
  request.pipe(onward);
}
