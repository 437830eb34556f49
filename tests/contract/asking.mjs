// The requests that each step of the tables makes, and what their answers are held to.
//
// A step: { of: operation, by: who calls it with success }, and
//   at        what stands in the path's {id} or {name}
//   body, type, query, headers   of the request
//   mine      names of those whose it is, where the contract lets people at their own things
//   unassigned   an exercise that no cohort has to do
//   absent    the status where the path names nothing, if it is not 404
//   shared    an exercise that instructors share and the demo cohort has to do
//   hidden    students do not see it yet
//   tag       the ETag for If-Match, where no GET has it
//   tagged    sends If-Match although it is not required
//   alone     nobody else calls it
//   status    of the success, where the operation has several
//   before, after   around the call
import { wrongBodies, wrongQueries } from "./wrong.mjs";

const kNoId = "00000000-0000-7000-8000-000000000000";
const kCallers = ["nobody", "sam", "sue", "tom", "ben", "ivo", "admin"];
const kDemo = ["sam", "sue", "ben", "bea"];
const kReads = ["GET", "HEAD"];
const kMethods = ["GET", "HEAD", "POST", "PUT", "PATCH", "DELETE"];
// Of the connection, and of no answer in particular.
const kOfHttp = ["connection", "content-encoding", "content-length", "date", "keep-alive", "vary"];

// Members of answers that this school has no occasion for.
const kUnseen = [
  // Faults: of other servers, of a tooth, of a trial, of a recording.
  ...["Health.peers", "ToothImport.problem", "ExerciseTrial.problem", "AttemptDetail.contradictions"],
  // Of classes, of which there is one of two.
  ...["AssignmentInsight.outliers", "StandardSetting.borderline", "StandardSetting.angoff", "AttemptDetail.reference"],
  "Marking.results.agreement.limits_of_agreement",
  // Of one marker: a blind marking has two.
  "Marking.results.agreement.why",
  // Of exams, which take a station with somebody at it.
  ...["AttemptDetail.evidence", "AttemptDetail.sign_off"],
  // What the server does once a week.
  "Backups.drill",
  // Of scores whose limit is near what was measured.
  "Score.borderline",
  // Of other devices.
  "Score.metrics",
];
// Members that answers have where the steps take longer than two minutes.
const kPerhapsUnseen = ["ServerHealth.recordings.late"];

export class Asking {
  answers = 0;
  #found = new Map(); // a kind of difference, and how often
  #done = new Set();
  #seen = new Map(); // an object of the contract's schemas, and its members that were answered

  constructor(contract, w) {
    this.contract = contract;
    this.w = w;
    this.byId = new Map(contract.operations.map((operation) => [operation.id, operation]));
    this.always = Object.entries(contract.document["x-always"] ?? {}).map(([name, value]) => [
      name.toLowerCase(),
      value,
    ]);
    this.codes = contract.document.components.responses.Error["x-codes"] ?? {};
  }

  #note(operation, what) {
    const key = `${operation.place}: ${what}`;
    this.#found.set(key, (this.#found.get(key) ?? 0) + 1);
  }

  problems() {
    const idle = this.contract.operations.filter(({ id }) => !this.#done.has(id));
    return [
      ...[...this.#found].map(([what, times]) => `${what}${times > 1 ? ` (${times} times)` : ""}`),
      ...idle.map(({ place, id }) => `${place}: no step calls ${id} with success; add one to the tables of steps`),
      ...this.#unseen(),
    ];
  }

  // Where the contract describes a member that no answer had, and which of `kUnseen` an answer had.
  #unseen() {
    const seen = (owner, name) => this.#seen.get(owner)?.has(name) === true;
    const places = this.contract
      .answered(seen)
      .filter(({ owner, name }) => !seen(owner, name))
      .map(({ place }) => place);
    const within = (place, whole) => place === whole || place.startsWith(`${whole}.`);
    return [
      ...places
        .filter((place) => ![...kUnseen, ...kPerhapsUnseen].some((whole) => within(place, whole)))
        .map((place) => `${place}: no answer had it`),
      ...kUnseen
        .filter((whole) => !places.some((place) => within(place, whole)))
        .map((whole) => `${whole}: answers had all of it; take it off kUnseen`),
    ];
  }

  async steps(list) {
    for (const step of list) {
      const operation = this.byId.get(step.of);
      if (operation === undefined) throw new Error(`the contract has no operation ${step.of}`);
      try {
        await this.#step(step, operation);
      } catch (error) {
        this.#note(operation, `${error.stack}`);
      }
    }
  }

  // Whether the contract lets a person at this step's thing; undefined: it does not let the role in at all.
  #may(name, operation, step) {
    if (operation.open) return true;
    if (name === "nobody") return undefined;
    const { role } = this.w[name];
    const scope = operation.may[role];
    if (scope === undefined) return undefined;
    const aimed = step.at !== undefined || (scope === "cohort" && operation.method !== "GET");
    if (!aimed || scope === "all") return true;
    const own = step.mine?.includes(name) === true;
    const seen = { own, cohort: kDemo.includes(name), shared: own || (step.shared === true && role !== "student") };
    if (scope === "cohort" && step.unassigned) return false;
    return seen[scope];
  }

  // The statuses with which a person is turned away.
  #turnedAway(name, operation, step) {
    if (name === "nobody") return [401];
    if (this.#may(name, operation, step) === undefined) return [403];
    if (step.at === undefined) return [403, 404];
    // Whoever sees the thing is told that this is not theirs to do; to others there is no such thing.
    const [thing] = /^\/api\/v1\/[^/]+\/\{\w+\}/.exec(operation.path) ?? [];
    const look = this.contract.operations.find((of) => of.method === "GET" && of.path === thing);
    if (look === undefined) return [403, 404];
    return this.#may(name, look, step) ? [403] : [404];
  }

  #pathOf({ at, query = "" }, operation, id) {
    return operation.path.replace(/\{\w+\}/, encodeURIComponent(id ?? at?.(this.w) ?? "")) + query;
  }

  // The ETag that a change of the step's thing needs.
  async #tagOf(step, operation) {
    if (!operation.ifMatch && !step.tagged) return undefined;
    if (step.tag !== undefined) return step.tag(this.w);
    const readers = this.contract.operations
      .filter(
        ({ method, path, responses }) =>
          method === "GET" && operation.path.startsWith(path) && responses[200]?.headers?.ETag,
      )
      .sort((a, b) => b.path.length - a.path.length);
    const answer = await this.w[step.by].need("GET", this.#pathOf({ at: step.at }, readers[0]));
    return answer.headers.get("etag");
  }

  async #ask(
    person,
    step,
    operation,
    { id, query, body, type = step.type, headers, csrf, method = operation.method } = {},
  ) {
    const sent = { ...(body !== undefined && { body, type }), headers: { ...step.headers, ...headers }, csrf };
    const path = this.#pathOf({ ...step, ...(query !== undefined && { query }) }, operation, id);
    const answer = await person.ask(method, path, sent);
    ++this.answers;
    this.#hold(operation, answer, method);
    return answer;
  }

  #expect(operation, answer, statuses, what) {
    if (!statuses.includes(answer.status))
      this.#note(
        operation,
        `${what}: expected ${statuses.join(" or ")}, found ${answer.status} ${(answer.text ?? "").slice(0, 160)}`,
      );
  }

  async #step(step, operation) {
    const { w } = this;
    await step.before?.(w);
    const body = step.body?.(w);
    const tag = await this.#tagOf(step, operation);
    const headers = tag && { "if-match": tag };
    const right = { body, headers };
    const streams = Object.keys(operation.responses[200]?.content ?? {}).includes("text/event-stream");
    for (const name of step.alone ? ["nobody"] : kCallers) {
      if (name === step.by || operation.open || w[name] === undefined) continue;
      const may = this.#may(name, operation, step);
      const hidden = step.hidden && w[name].role === "student";
      if (may && !hidden) {
        if (!streams) await this.#alsoMay(name, step, operation, right);
        continue;
      }
      const answer = await this.#ask(w[name], step, operation, right);
      this.#expect(operation, answer, may ? [403] : this.#turnedAway(name, operation, step), `as ${name}`);
    }
    if (!this.#done.has(operation.id)) await this.#wrong(step, operation, right);
    const answer = streams ? await this.#stream(step, operation) : await this.#ask(w[step.by], step, operation, right);
    const success = step.status
      ? [step.status]
      : Object.keys(operation.responses)
          .map(Number)
          .filter((status) => status < 300);
    this.#expect(operation, answer, success, `as ${step.by}`);
    if (answer.status >= 300) return;
    this.#done.add(operation.id);
    await step.after?.(w, answer);
    if (operation.method !== "GET" || streams) return;
    await this.#head(step, operation, answer);
    if (operation.responses[304] === undefined) return;
    const kept = await this.#ask(w[step.by], step, operation, {
      headers: { "if-none-match": answer.headers.get("etag") },
    });
    this.#expect(operation, kept, [304], "with If-None-Match");
  }

  // A read answers everybody who may; of a change only that it is not the person that is refused.
  async #alsoMay(name, step, operation, { body, headers }) {
    const person = this.w[name];
    if (operation.method === "GET") {
      const answer = await this.#ask(person, step, operation);
      this.#expect(operation, answer, [200, 206], `as ${name}`);
      this.#keepsToItself(name, step, operation, answer);
    } else if (body !== undefined && step.type === undefined && !Array.isArray(body)) {
      const answer = await this.#ask(person, step, operation, { headers, body: { ...body, nonsense: 1 } });
      this.#expect(operation, answer, [400, 201], `as ${name} with an unknown member`);
    } else if (operation.ifMatch) {
      const answer = await this.#ask(person, step, operation, { body });
      this.#expect(operation, answer, [428], `as ${name} without If-Match`);
    }
  }

  // A list names nothing of a cohort to those outside it.
  #keepsToItself(name, step, operation, { text }) {
    const scope = operation.may[this.w[name].role];
    if (step.at !== undefined || scope === "all" || kDemo.includes(name)) return;
    for (const [what, id] of Object.entries(this.w.ofDemo()))
      if (id !== undefined && text.includes(id))
        this.#note(operation, `as ${name}: the answer names the ${what} of another cohort`);
  }

  // Each path with the methods that it does not have, and a path that is none.
  async methods() {
    for (const path of new Set(this.contract.operations.map((of) => of.path))) {
      const operations = this.contract.operations.filter((of) => of.path === path);
      const has = operations.flatMap(({ method }) => (method === "GET" ? ["GET", "HEAD"] : [method]));
      for (const method of kMethods.filter((one) => !has.includes(one))) {
        const answer = await this.w.admin.ask(method, path.replace(/\{\w+\}/, kNoId));
        ++this.answers;
        const allow = (answer.headers.get("allow") ?? "").split(", ").sort().join();
        const refused = method === "HEAD" || answer.json?.error?.code === "method_not_allowed";
        if (answer.status !== 405 || allow !== [...has].sort().join() || !refused)
          this.#note(operations[0], `${method}: expected 405 and Allow: ${has}, found ${answer.status} and ${allow}`);
      }
    }
  }

  async #wrong(step, operation, { body, headers }) {
    const person = this.w[step.by];
    const expect = async (statuses, what, request, field) => {
      const answer = await this.#ask(person, step, operation, { body, headers, ...request });
      this.#expect(operation, answer, statuses, what);
      const found = answer.json?.error?.field;
      if (field !== undefined && statuses.includes(answer.status) && found?.split(/[.[]/)[0] !== field)
        this.#note(operation, `${what}: expected the field ${field}, found ${JSON.stringify(found)}`);
    };
    if (operation.guarded) await expect([403], "without X-Enamel-Csrf", { csrf: false }, "x-enamel-csrf");
    if (!kReads.includes(operation.method)) {
      await expect(
        [403],
        "from another site",
        { headers: { ...headers, "sec-fetch-site": "cross-site" } },
        "sec-fetch-site",
      );
      await expect([403], "from another origin", { headers: { ...headers, origin: "https://example.org" } }, "origin");
    }
    const { inPath } = operation;
    if (inPath?.name === "id") {
      await expect([400], "with an id that is none", { id: "x" }, "id");
      await expect([404], "of something that is not there", { id: kNoId });
    } else if (inPath !== undefined) {
      await expect([400], "with a name that is none", { id: "A b" }, "name");
      await expect([step.absent ?? 404], "of something that is not there", { id: "no-such-name" });
    }
    if (operation.ifMatch) {
      await expect([428], "without If-Match", { headers: {} }, "if-match");
      await expect([428], "with an If-Match that is no ETag", { headers: { "if-match": "7" } }, "if-match");
      await expect([412], "with an old If-Match", { headers: { "if-match": '"999999"' } }, "if-match");
    }
    for (const [name, text] of wrongQueries(this.contract, operation.query))
      await expect([400], `with ${name}=${text.slice(0, 12)}`, { query: `?${name}=${encodeURIComponent(text)}` }, name);
    if (operation.body === undefined) return;
    await expect([415], "with another Content-Type", { type: "text/x-nonsense" }, "content-type");
    if (operation.body.type !== "application/json") {
      for (const { status, ...request } of step.wrong ?? []) await expect([status], "with a wrong body", request);
      return;
    }
    if (operation.body.required) await expect([400], "with a body that is no JSON", { body: "{" });
    for (const [what, field, wrong] of wrongBodies(this.contract, operation.body.schema, body))
      await expect([400], `with ${field || "a body"} ${what}`, { body: wrong }, field);
  }

  async #head(step, operation, answer) {
    const head = await this.#ask(this.w[step.by], step, operation, { method: "HEAD" });
    if (head.status !== answer.status) this.#note(operation, `HEAD answers ${head.status}, GET ${answer.status}`);
    if (head.bytes.length > 0) this.#note(operation, "HEAD has a body");
  }

  // The first event of a stream.
  async #stream(step, operation) {
    const answer = await this.w[step.by].ask("GET", this.#pathOf(step, operation), { only: true });
    ++this.answers;
    if (answer.status !== 200) return answer;
    this.#headers(operation, answer, operation.responses[200]);
    const schema = operation.responses[200].content["text/event-stream"].schema;
    let text = "";
    const decoder = new TextDecoder();
    for await (const bytes of answer.stream) {
      text += decoder.decode(bytes, { stream: true });
      const [, data] = /^event: ticks\ndata: (.*)$/m.exec(text) ?? [];
      if (data === undefined) continue;
      this.#body(operation, 200, schema, JSON.parse(data));
      break;
    }
    answer.end();
    return answer;
  }

  #hold(operation, answer, method) {
    const { status } = answer;
    const response = this.contract.responseOf(operation, status);
    if (response === undefined) {
      this.#note(operation, `${status} is not in the contract: ${(answer.text ?? "").slice(0, 160)}`);
      return;
    }
    this.#headers(operation, answer, response);
    if (method === "HEAD") return;
    const [type] = (answer.headers.get("content-type") ?? "").split(";");
    if (response.content === undefined) {
      if (type !== "" || answer.bytes.length > 0) this.#note(operation, `${status} has a body that is not described`);
      return;
    }
    const content = response.content[type];
    if (content === undefined) {
      this.#note(operation, `${status} has the Content-Type "${type}", which is not in the contract`);
      return;
    }
    if (answer.json !== undefined) this.#body(operation, status, content.schema, answer.json);
    else if (type === "application/json") this.#note(operation, `${status} has no body`);
    else if (answer.bytes.length === 0) this.#note(operation, `${status} has no body`);
    if (status >= 400) this.#refusal(operation, answer);
  }

  #body(operation, status, schema, value) {
    for (const problem of new Set(this.contract.problemsOf(schema, value)))
      this.#note(operation, `${status}: ${problem}`);
    this.contract.members(schema, value, (owner, name) => {
      if (!this.#seen.has(owner)) this.#seen.set(owner, new Set());
      this.#seen.get(owner).add(name);
    });
  }

  #refusal(operation, { status, json }) {
    const code = json?.error?.code;
    if (!(this.codes[status] ?? []).includes(code)) this.#note(operation, `${status} has the code ${code}`);
  }

  #headers(operation, { status, headers }, response) {
    const described = new Map(Object.entries(response.headers ?? {}).map(([name, of]) => [name.toLowerCase(), of]));
    for (const [name, value] of this.always) {
      if (described.has(name)) continue;
      const fits =
        typeof value === "string" ? headers.get(name) === value : this.contract.fits(value, headers.get(name));
      if (!fits) this.#note(operation, `${status}: the header ${name} is ${headers.get(name)}`);
    }
    for (const [name, of] of described) {
      const { schema, required } = this.contract.resolved(of);
      const found = headers.get(name);
      if (found === null && required) this.#note(operation, `${status}: the header ${name} is missing`);
      if (found === null) continue;
      for (const problem of this.contract.problemsOf(schema, schema.type === "integer" ? Number(found) : found))
        this.#note(operation, `${status}: the header ${name}: ${problem}`);
    }
    const known = [...kOfHttp, "content-type", ...this.always.map(([name]) => name)];
    for (const name of headers.keys())
      if (!known.includes(name) && !described.has(name))
        this.#note(operation, `${status}: the header ${name} is not described`);
  }
}
