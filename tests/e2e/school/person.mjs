// Somebody at the server's interface, beside the page.
import { Person } from "../../contract/client.mjs";

// { get, post, put, patch, remove } answer with the body, and fail where the server refuses. `etag`: of the last answer.
export async function signedInAt(url, { login, password }) {
  const person = await Person.signedIn(url, login, login, password);
  const self = { id: person.id, login, etag: undefined };
  const send = (method) => async (path, body, headers) => {
    const answer = await person.need(method, `/api/v1${path}`, { body, headers });
    self.etag = answer.headers.get("etag");
    return answer.json;
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
    head: async (path) => (await person.ask("HEAD", `/api/v1${path}`)).status,
    postChanged: changed("POST"),
  });
}
