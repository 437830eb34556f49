// Requests of one person at a server, as a browser sends them.

export class Person {
  constructor(url, name) {
    Object.assign(this, { url, name });
  }

  // Throws where it is refused: for what a test needs, and does not look at.
  static async signedIn(url, name, login, password) {
    const person = new Person(url, name);
    const answer = await person.ask("POST", "/api/v1/session", { body: { login, password } });
    if (answer.status !== 200) throw new Error(`${login} cannot sign in: ${answer.status} ${answer.text}`);
    person.take(answer);
    return Object.assign(person, { login, password });
  }

  // Goes on with the session of an answer.
  take({ headers, json }) {
    this.cookie = headers.getSetCookie()[0].split(";")[0];
    this.csrf = json.csrf;
    this.id = json.person.id;
    this.role = json.person.role;
  }

  // `body`: JSON unless it is text or bytes. `headers` go before what would be sent.
  async ask(method, path, { body, type, headers = {}, csrf = true, only = false } = {}) {
    const plain = body === undefined || typeof body === "string" || body instanceof Uint8Array;
    const sent = {
      ...(this.cookie && { cookie: this.cookie }),
      ...(csrf && this.csrf && !["GET", "HEAD"].includes(method) && { "x-enamel-csrf": this.csrf }),
      ...(body !== undefined && { "content-type": type ?? "application/json" }),
      ...headers,
    };
    const ending = new AbortController();
    const answer = await fetch(this.url + path, {
      method,
      headers: sent,
      body: plain ? body : JSON.stringify(body),
      redirect: "manual",
      signal: ending.signal,
    });
    if (only) return { status: answer.status, headers: answer.headers, stream: answer.body, end: () => ending.abort() };
    const bytes = new Uint8Array(await answer.arrayBuffer());
    const json = (answer.headers.get("content-type") ?? "").startsWith("application/json");
    const text = new TextDecoder().decode(bytes);
    return {
      status: answer.status,
      headers: answer.headers,
      bytes,
      text,
      json: json && text !== "" ? JSON.parse(text) : undefined,
    };
  }

  // An answer that has to be a success.
  async need(method, path, options) {
    const answer = await this.ask(method, path, options);
    if (answer.status >= 300) throw new Error(`${this.name}: ${method} ${path}: ${answer.status} ${answer.text}`);
    return answer;
  }
}

// A sanitizer's programs take minutes for seconds.
const kPatience_ms = /[/](asan|tsan)[/]/.test(process.env.ENAMEL_BIN ?? "") ? 300_000 : 60_000;

// Asks until `enough(answer)`, and returns that answer. Throws after a minute, or `most_ms`.
export async function until(what, ask, enough = Boolean, most_ms = kPatience_ms) {
  const end = Date.now() + most_ms;
  for (;;) {
    const answer = await ask();
    if (enough(answer)) return answer;
    if (Date.now() > end) throw new Error(`${what}: not in time; last: ${JSON.stringify(answer?.json ?? null)}`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}
