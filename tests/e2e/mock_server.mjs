// The HTTP API of schemas/api/openapi.yaml with invented data, and the built page with the very
// headers the real server sends: the page can be tested without a server, a station or a database.
//   node mock_server.mjs DIST [PORT]     to look at the page by hand
import { randomBytes } from "node:crypto";
import { existsSync, readFileSync, statSync } from "node:fs";
import { createServer } from "node:http";
import { extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";
import * as data from "./mock_data.mjs";
import { toothSurface } from "./mock_tooth.mjs";

export const kPageHeaders = {
  "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; font-src 'self'; " +
    "connect-src 'self'; worker-src 'self'; manifest-src 'self'; frame-ancestors 'none'; base-uri 'none'; object-src 'none'; " +
    "form-action 'self'; require-trusted-types-for 'script'",
  "X-Content-Type-Options": "nosniff",
  "Referrer-Policy": "no-referrer",
  "Cross-Origin-Opener-Policy": "same-origin",
  "Cross-Origin-Embedder-Policy": "require-corp",
  "Cross-Origin-Resource-Policy": "same-origin",
  "Permissions-Policy": "camera=(), microphone=(), geolocation=()",
};
const kTypes = { ".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8", ".svg": "image/svg+xml" };
const kMaxBodyBytes = 1 << 20;
const kScoringStep = 0.25;

export async function startMockServer({ dist, port = 0 }) {
  const world = { dist, attempts: data.makeAttempts(), sessions: new Map(), surfaces: new Map() };
  const server = createServer((request, response) => {
    answer(world, request).then((reply) => send(response, reply), (error) => send(response, refusal(500, "internal", String(error))));
  });
  await new Promise((resolve, reject) => server.once("error", reject).listen(port, "127.0.0.1", resolve));
  return {
    url: `http://127.0.0.1:${server.address().port}`,
    close: () => new Promise((resolve) => {
      server.closeAllConnections?.();
      server.close(resolve);
    }),
  };
}

function send(response, { status, body, headers = {} }) {
  response.writeHead(status, { ...kPageHeaders, ...headers });
  response.end(body);
}

const json = (value, status = 200, headers = {}) =>
  ({ status, body: JSON.stringify(value), headers: { "Content-Type": "application/json", "Cache-Control": "no-store", ...headers } });
const refusal = (status, code, message) => json({ error: { code, message, field: "" } }, status);
const notFound = () => refusal(404, "not_found", "There is no such thing.");

async function answer(world, request) {
  const url = new URL(request.url, "http://mock");
  if (!url.pathname.startsWith("/api/")) return pageFile(world, request, url.pathname);
  const path = url.pathname.replace(/^\/api\/v1/, "");
  if (path === "/session" && request.method === "POST") return signIn(world, await readBody(request));
  const session = world.sessions.get(cookieOf(request));
  if (session === undefined) return refusal(401, "unauthenticated", "Sign in first.");
  if (request.method !== "GET" && request.headers["x-enamel-csrf"] !== session.csrf) return refusal(403, "forbidden", "The csrf value is missing.");
  if (path === "/session" && request.method === "DELETE") {
    world.sessions.delete(cookieOf(request));
    return { status: 204 };
  }
  const body = request.method === "POST" ? await readBody(request) : undefined;
  return api(world, session.person, request.method, path, url.searchParams, body) ?? notFound();
}

function signIn(world, body) {
  const person = data.people.find((item) => item.login === body?.login && item.password === body?.password);
  if (person === undefined) return refusal(401, "unauthenticated", "Login and password do not match.");
  const token = randomBytes(32).toString("hex");
  const session = { person, csrf: randomBytes(16).toString("hex") };
  world.sessions.set(token, session);
  return json(sessionBody(session), 200, { "Set-Cookie": `enamel_session=${token}; HttpOnly; SameSite=Strict; Path=/` });
}

function sessionBody({ person: { id, login, display_name, role }, csrf }) {
  return { person: { id, login, display_name, role }, csrf };
}

function api(world, person, method, path, query, body) {
  const teacher = person.role !== "student";
  const admin = person.role === "admin";
  const [collection, id, part] = path.split("/").slice(1);
  if (method === "GET" && id === undefined) {
    switch (collection) {
      case "session": return json(sessionBody([...world.sessions.values()].find((item) => item.person === person)));
      case "exercises": return json({ exercises: data.exercises.map((exercise) => summaryFor(world, person, exercise)) });
      case "cohorts": return teacher ? json({ cohorts: data.cohorts }) : refusal(403, "forbidden", "Students do not see cohorts.");
      case "attempts": return json(attemptPage(world, person, query));
      case "profiles": return json({ profiles: data.profiles });
      case "stations": return teacher ? json({ stations: data.stations }) : refusal(403, "forbidden", "Not for students.");
      case "audit": return admin ? json({ audit: data.audit }) : refusal(403, "forbidden", "Only for admins.");
      case "jobs": return admin ? json({ jobs: data.jobs }) : refusal(403, "forbidden", "Only for admins.");
      default: return undefined;
    }
  }
  if (collection === "exercises" && method === "GET") {
    const exercise = data.exercises.find((item) => item.id === id);
    return exercise === undefined ? undefined : json({ ...exercise, ...summaryFor(world, person, exercise), target: exercise.target, rubric: exercise.rubric });
  }
  if (collection !== "attempts") return undefined;
  const row = world.attempts.find((item) => item.id === id && (teacher || item.person.id === person.id));
  return row === undefined ? undefined : attemptPart(world, person, row, method, part, body);
}

function attemptPart(world, person, row, method, part, body) {
  const hidden = person.role === "student" && isHidden(row);
  if (method === "POST") return changeAttempt(world, person, row, part, body);
  if (part === undefined) {
    advance(row);
    return json({ ...visible(person, row), duration_s: row.ticks / 1000, reference: row.state === "scored" ? data.referenceDetail : null });
  }
  if (row.state !== "scored") return refusal(409, "conflict", "The attempt is not scored yet.");
  switch (part) {
    case "score": return hidden ? refusal(403, "forbidden", "The score is not released yet.") : json(data.scoreOf(row));
    case "series": return json(data.seriesOf());
    case "surface": return { status: 200, body: surfaceFor(world, !hidden), headers: { "Content-Type": "application/octet-stream", "Cache-Control": "no-store" } };
    default: return undefined;
  }
}

function changeAttempt(world, person, row, part, body) {
  if (person.role === "student") return refusal(403, "forbidden", "Only an instructor may do that.");
  if (part === "release") {
    row.released = true;
    return { status: 204 };
  }
  if (part === "reference" && typeof body?.dentist === "string" && body.dentist !== "") {
    for (const other of world.attempts) other.is_reference = other === row;
    return json({ id: row.id, exercise_id: row.exercise.id, attempt_id: row.id, dentist: body.dentist, version: 2, created_ms: row.sealed_ms }, 201);
  }
  return undefined;
}

// Each look at an attempt that is being scored finds it further on.
function advance(row) {
  if (row.state !== "scoring") return;
  row.progress = Math.min(1, row.progress + kScoringStep);
  if (row.progress === 1) Object.assign(row, { state: "scored", score: 80, critical_fail: false });
}

function isHidden(row) {
  return !row.released && data.exercises.find((item) => item.id === row.exercise.id)?.graded === true;
}

function visible(person, row) {
  return person.role === "student" && isHidden(row) ? { ...row, score: null, critical_fail: null } : row;
}

function summaryFor(world, person, { target: _target, rubric: _rubric, ...summary }) {
  return { ...summary, my_attempts: world.attempts.filter((row) => row.exercise.id === summary.id && row.person.id === person.id).length };
}

function attemptPage(world, person, query) {
  const members = data.cohorts.find((cohort) => cohort.id === query.get("cohort"))?.members.map((member) => member.id);
  const mayShow = (row) => (person.role === "student" ? row.person.id === person.id : members === undefined || members.includes(row.person.id)) &&
    (query.get("exercise") === null || row.exercise.id === query.get("exercise")) && (query.get("person") === null || row.person.id === query.get("person"));
  const rows = world.attempts.filter(mayShow);
  const first = query.get("before") === null ? 0 : rows.findIndex((row) => row.id === query.get("before")) + 1;
  const page = rows.slice(first, first + Number(query.get("limit") ?? 50));
  const last = first + page.length >= rows.length;
  return { attempts: page.map((row) => visible(person, row)), next: last ? null : page.at(-1).id };
}

function surfaceFor(world, withDeviation) {
  if (!world.surfaces.has(withDeviation)) world.surfaces.set(withDeviation, toothSurface({ withDeviation }));
  return world.surfaces.get(withDeviation);
}

function cookieOf(request) {
  return /(?:^|;\s*)enamel_session=([0-9a-f]+)/.exec(request.headers.cookie ?? "")?.[1];
}

async function readBody(request) {
  let text = "";
  for await (const chunk of request) {
    text += chunk;
    if (text.length > kMaxBodyBytes) return undefined;
  }
  try {
    return JSON.parse(text);
  } catch {
    return undefined;
  }
}

function pageFile(world, request, path) {
  const file = normalize(join(world.dist, path));
  const found = file.startsWith(normalize(world.dist)) && existsSync(file) && statSync(file).isFile() ? file : join(world.dist, "index.html");
  const packed = (request.headers["accept-encoding"] ?? "").includes("br") && existsSync(`${found}.br`);
  return {
    status: 200, body: readFileSync(packed ? `${found}.br` : found),
    headers: {
      "Content-Type": kTypes[extname(found)] ?? "application/octet-stream", Vary: "Accept-Encoding",
      "Cache-Control": found.endsWith("index.html") ? "no-cache" : "public, max-age=31536000, immutable",
      ...(packed ? { "Content-Encoding": "br" } : {}),
    },
  };
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [, , dist, port] = process.argv;
  if (dist === undefined) throw new Error("expected the folder of the built page: node mock_server.mjs DIST [PORT]");
  const server = await startMockServer({ dist, port: Number(port ?? 0) });
  console.log(server.url);
  for (const person of data.people) console.log(`${person.role}: ${person.login} / ${person.password}`);
}
