// The HTTP API of schemas/api/openapi.yaml with invented data, and the built page with the very
// headers the real server sends: the page can be tested without a server, a station or a database.
//   node mock_server.mjs DIST [PORT]     to look at the page by hand
import { randomBytes } from "node:crypto";
import { existsSync, readFileSync, statSync } from "node:fs";
import { createServer } from "node:http";
import { extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";
import { editingRoutes } from "./mock_editing.mjs";
import { peopleRoutes, sessionView } from "./mock_people.mjs";
import { empty, forbidden, invalid, json, notFound, refusal } from "./mock_reply.mjs";
import { teachingRoutes } from "./mock_teaching.mjs";
import { makeWorld, newId } from "./mock_world.mjs";
import { people } from "./mock_data.mjs";

export const kPageHeaders = {
  "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; font-src 'self'; " +
    "connect-src 'self'; worker-src 'self'; manifest-src 'self'; frame-ancestors 'none'; base-uri 'none'; object-src 'none'; " +
    "form-action 'self'; require-trusted-types-for 'script'; trusted-types enamel-worker",
  "X-Content-Type-Options": "nosniff",
  "Referrer-Policy": "no-referrer",
  "Cross-Origin-Opener-Policy": "same-origin",
  "Cross-Origin-Embedder-Policy": "require-corp",
  "Cross-Origin-Resource-Policy": "same-origin",
  "Permissions-Policy": "camera=(), microphone=(), geolocation=()",
};
const kTypes = { ".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8", ".svg": "image/svg+xml" };
const kMaxBodyBytes = 1 << 20;
const kRanks = { person: 0, student: 0, instructor: 1, admin: 2 };

// Every route of the mock, as the contract writes it.
export const mockRoutes = { "POST /first-admin": ["person", notFound], ...peopleRoutes, ...teachingRoutes, ...editingRoutes };

export async function startMockServer({ dist, port = 0 }) {
  const world = makeWorld(dist);
  const server = createServer((request, response) => {
    answer(world, request).then((reply) => send(response, reply), (error) => send(response, refusal(500, "internal", String(error.stack))));
  });
  await new Promise((resolve, reject) => server.once("error", reject).listen(port, "127.0.0.1", resolve));
  return {
    world,
    url: `http://127.0.0.1:${server.address().port}`,
    close: () => new Promise((resolve) => {
      server.closeAllConnections?.();
      server.close(resolve);
    }),
  };
}

function send(response, { status, body, headers = {}, stream }) {
  response.writeHead(status, { ...kPageHeaders, ...headers });
  if (stream === undefined) response.end(body);
  else stream(response);
}

async function answer(world, request) {
  const url = new URL(request.url, "http://mock");
  if (!url.pathname.startsWith("/api/")) return pageFile(world, request, url.pathname);
  const path = url.pathname.slice("/api/v1".length);
  const text = request.method === "GET" ? "" : await readBody(request);
  if (path === "/session" && request.method === "POST") return signIn(world, parsed(text));
  if (path === "/first-admin" && request.method === "POST") return makeFirstAdmin(world, parsed(text));
  const session = world.sessions.get(cookieOf(request));
  if (session === undefined || session.person.disabled) return refusal(401, "unauthenticated", "Sign in first.");
  if (request.method !== "GET" && request.headers["x-enamel-csrf"] !== session.csrf) return refusal(403, "forbidden", "The csrf value is missing.");
  if (path === "/session" && request.method === "GET") return json(sessionView(session));
  if (path === "/session" && request.method === "DELETE") {
    world.sessions.delete(cookieOf(request));
    return empty();
  }
  return api(world, session, request, path, url.searchParams, text);
}

function api(world, session, request, path, query, text) {
  const { person } = session;
  if (person.must_change_password && path !== "/session/password") return refusal(403, "change_password", "Change your password first.");
  const found = routeOf(request.method, path);
  if (found === undefined) return notFound();
  const [need, handler] = found.route;
  if (kRanks[person.role] < kRanks[need]) return forbidden();
  return handler({ world, session, person, request, query, text, id: found.id, body: text === "" ? {} : parsed(text) });
}

// At most one part of a path is an id or a name.
function routeOf(method, path) {
  const parts = path.split("/").slice(1).map(decodeURIComponent);
  for (let at = -1; at < parts.length; ++at) {
    for (const hole of ["{id}", "{name}"]) {
      const route = mockRoutes[`${method} /${parts.map((part, i) => i === at ? hole : part).join("/")}`];
      if (route !== undefined) return { route, id: parts[at] };
    }
  }
  return undefined;
}

function signIn(world, body) {
  const person = world.people.find((item) => item.login === body?.login && item.password === body?.password && !item.disabled);
  if (person === undefined) return refusal(401, "unauthenticated", "Login and password do not match.");
  const token = randomBytes(32).toString("hex");
  const session = { id: newId(world), person, csrf: randomBytes(16).toString("hex"), via: "page", address: "127.0.0.1", device: "Chrome on Linux", created_ms: world.nowMs, confirmedMs: world.nowMs };
  world.sessions.set(token, session);
  return json(sessionView(session), 200, { "Set-Cookie": `enamel_session=${token}; HttpOnly; SameSite=Strict; Path=/` });
}

function makeFirstAdmin(world, body) {
  if (body.token !== world.firstAdminToken) return refusal(403, "forbidden", "This link is not good any more.", "token");
  if (body.password.length < 12) return invalid("password", "this password is easy to guess");
  const person = { id: newId(world), login: body.login, display_name: body.display_name, role: "admin", disabled: false, must_change_password: false, created_ms: world.nowMs, revision: 1, password: body.password };
  world.people.push(person);
  world.firstAdminToken = undefined;
  const { password: _password, ...made } = person;
  return json(made, 201);
}

function cookieOf(request) {
  return /(?:^|;\s*)enamel_session=([0-9a-f]+)/.exec(request.headers.cookie ?? "")?.[1];
}

async function readBody(request) {
  let text = "";
  for await (const chunk of request) {
    text += chunk;
    if (text.length > kMaxBodyBytes) return "";
  }
  return text;
}

function parsed(text) {
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
  for (const person of people) console.log(`${person.role}: ${person.login} / ${person.password}`);
}
