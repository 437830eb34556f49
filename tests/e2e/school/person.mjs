// Somebody at the server's interface, beside the page.
import assert from "node:assert/strict";

export async function until(what, ask, mostMs = 300_000) {
  const end = performance.now() + mostMs;
  for (;;) {
    const found = await ask();
    if (found) return found;
    assert.ok(performance.now() < end, `${what}: not within ${mostMs} ms`);
    await new Promise((next) => setTimeout(next, 100));
  }
}

// { get, post, put, patch, remove } answer with the body, and fail where the server refuses. `etag`: of the last answer.
export async function signedInAt(url, { login, password }) {
  const json = { "Content-Type": "application/json", Origin: url };
  const begun = await fetch(`${url}/api/v1/session`, {
    method: "POST",
    headers: json,
    body: JSON.stringify({ login, password }),
  });
  assert.equal(begun.status, 200, `${login} signs in`);
  const { csrf, person } = await begun.json();
  const headers = { ...json, Cookie: begun.headers.get("set-cookie").split(";")[0], "X-Enamel-Csrf": csrf };
  const self = { id: person.id, login, etag: undefined };
  const send =
    (method) =>
    async (path, body, more = {}) => {
      const answer = await fetch(`${url}/api/v1${path}`, {
        method,
        headers: { ...headers, ...more },
        body: body === undefined ? undefined : JSON.stringify(body),
      });
      const text = await answer.text();
      assert.ok(answer.ok, `${login}: ${method} ${path}: ${answer.status} ${text.slice(0, 400)}`);
      self.etag = answer.headers.get("etag");
      return text === "" ? undefined : JSON.parse(text);
    };
  const get = send("GET");
  // Changes what it has just read, as whoever comes first does.
  const changed =
    (method) =>
    async (path, change, more = "") => {
      const now = await get(path);
      const tag = self.etag;
      return send(method)(path + more, typeof change === "function" ? change(now) : change, { "If-Match": tag });
    };
  return Object.assign(self, {
    get,
    send,
    post: send("POST"),
    put: changed("PUT"),
    patch: changed("PATCH"),
    remove: changed("DELETE"),
    head: async (path) => (await fetch(`${url}/api/v1${path}`, { method: "HEAD", headers })).status,
    postChanged: changed("POST"),
  });
}
