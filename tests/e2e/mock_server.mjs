// Serves the HTTP API from its contract (contract.mjs) and the built page with the headers of the
// real server, so that the page can be tested without a server, a station or a database. Both
// requests and answers are validated: an answer that breaks the contract becomes a 500 and is kept
// in `broken`. Lists, changes and tags follow from the contract; mock_rules.mjs has the exceptions,
// mock_world.mjs the data.
//   node mock_server.mjs DIST [PORT]     to try the page by hand
import { existsSync, readFileSync, statSync } from "node:fs";
import { createServer } from "node:http";
import { dirname, extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";
import {
  conflict,
  fitted,
  forbidden,
  invalid,
  operationFor,
  operations,
  problemOf,
  refused,
  Reply,
  sampleOf,
} from "./contract.mjs";
import { confirmed, filters, mayCall, rules, views, visible } from "./mock_rules.mjs";
import { tagOf } from "./mock_teaching.mjs";
import { added, makeWorld, people } from "./mock_world.mjs";

const kPageHeaders = {
  "Content-Security-Policy":
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; font-src 'self'; " +
    "connect-src 'self'; worker-src 'self'; manifest-src 'self'; frame-ancestors 'none'; base-uri 'none'; object-src 'none'; " +
    "form-action 'self'; require-trusted-types-for 'script'; trusted-types enamel-worker",
  "X-Content-Type-Options": "nosniff",
  "Referrer-Policy": "no-referrer",
  "Cross-Origin-Opener-Policy": "same-origin",
  "Cross-Origin-Embedder-Policy": "require-corp",
  "Cross-Origin-Resource-Policy": "same-origin",
  "Permissions-Policy": "camera=(), microphone=(), geolocation=()",
};
const kTypes = {
  ".html": "text/html; charset=utf-8",
  ".js": "text/javascript; charset=utf-8",
  ".css": "text/css; charset=utf-8",
  ".svg": "image/svg+xml",
};

const notFound = () => refused(404, "not_found", "There is no such thing.");
const kConfirmedMs = 5 * 60_000;

// Several flows share a server: `reset` gives it another world.
export async function startMockServer({ dist, port = 0 }) {
  const mock = {
    world: makeWorld(),
    broken: [],
    reset: () => {
      mock.world = makeWorld();
    },
  };
  const server = createServer((request, response) => {
    answer(mock, dist, request)
      .catch((error) => {
        mock.broken.push(`${request.method} ${request.url}: ${error.stack}`);
        return {
          status: 500,
          headers: {},
          body: JSON.stringify({ error: { code: "internal", message: String(error.message), field: "" } }),
        };
      })
      .then(({ status, headers, body, stream }) => {
        response.writeHead(status, { ...kPageHeaders, ...headers });
        if (stream === undefined) response.end(body);
        else stream(response);
      });
  });
  await new Promise((resolve, reject) => server.once("error", reject).listen(port, "127.0.0.1", resolve));
  mock.url = `http://127.0.0.1:${server.address().port}`;
  mock.close = () =>
    new Promise((resolve) => {
      server.closeAllConnections?.();
      server.close(resolve);
    });
  return mock;
}

async function answer({ world }, dist, request) {
  const url = new URL(request.url, "http://mock");
  if (!url.pathname.startsWith("/api/v1/")) return pageFile(dist, request, url.pathname);
  const found = operationFor(request.method, url.pathname.slice("/api/v1".length));
  const bytes = await readBody(request);
  if (found === undefined) return sent(undefined, notFound());
  const call = {
    ...found,
    world,
    request,
    bytes,
    session: world.sessions.find(({ token }) => token === cookieOf(request)),
  };
  return sent(call, prepared(call, url.searchParams) ?? carriedOut(call));
}

// Refuses requests that break the contract; otherwise adds query, body and row to `call`.
function prepared(call, search) {
  const { operation, session, request, world, id, bytes } = call;
  if (!operation.open) {
    if (session === undefined || session.person.disabled) return refused(401, "unauthenticated", "Sign in first.");
    call.person = session.person;
    if (
      operation.headers.some(({ name }) => name === "X-Enamel-Csrf") &&
      request.headers["x-enamel-csrf"] !== session.csrf
    )
      return forbidden("The csrf value is missing.");
    if (session.person.must_change_password && operation.path !== "/session/password" && operation.path !== "/session")
      return refused(403, "change_password", "Change your password first.");
    if (!mayCall(operation, session.person)) return forbidden("Only somebody with another role may do that.");
  }
  call.query = {};
  for (const { name, schema } of operation.query) {
    const text = search.get(name);
    call.query[name] = text === null ? schema.default : typed(schema, text);
    const problem = text === null ? undefined : problemOf(schema, call.query[name]);
    if (problem !== undefined) return invalid(name, problem.message);
  }
  if (operation.body !== undefined && (operation.needsBody || bytes.length > 0)) {
    call.body = parsed(bytes);
    const problem = problemOf(operation.body, call.body);
    if (problem !== undefined) return invalid(problem.field, problem.message);
  }
  if (confirmed(call) && world.nowMs - session.confirmedMs > kConfirmedMs)
    return refused(403, "confirm_password", "Give your password again: POST /api/v1/session/confirm.");
  call.collection = collectionOf(operation.segments[0]);
  call.rows = world[call.collection];
  if (id === undefined || call.rows === undefined) return undefined;
  call.row = call.rows.find((row) => (row.id ?? row.name) === id && isVisible(call, row));
  return call.row === undefined ? notFound() : unseen(call);
}

// The refusal when the caller has not seen the row as it is now.
function unseen(call) {
  const expects = call.operation.headers.find(({ name }) => name === "If-Match");
  const seen = call.request.headers["if-match"];
  if (expects === undefined || (seen === undefined && !expects.required)) return undefined;
  if (seen === undefined)
    return refused(428, "precondition_required", "Send If-Match with the ETag you have read.", "if-match");
  const tag = `"${tagOf(call)}"`;
  if (seen === tag) {
    call.changes = true;
    return undefined;
  }
  const { operation: read } = operationFor("GET", `/${call.operation.segments[0]}/${call.id}`) ?? {};
  const current =
    read === undefined ? {} : fitted(read.response(200).content["application/json"].schema, viewOf(call, call.row));
  return new Reply(
    {
      error: {
        code: "precondition_failed",
        message: "Somebody changed it meanwhile; read it again.",
        field: "revision",
      },
      current,
    },
    { status: 412, headers: { ETag: tag } },
  );
}

function carriedOut(call) {
  const rule = rules[call.operation.route] ?? standard;
  const result = rule(call);
  if (result instanceof Reply && result.status >= 400) return result;
  if (call.changes && call.row !== undefined) call.row.revision += 1;
  return result;
}

// What the contract itself says of lists and things.
function standard(call) {
  const {
    operation: { method, segments, status, response },
    row,
    rows,
    body,
    world,
  } = call;
  const list = listIn(response(status));
  if (method === "GET") return list === undefined ? row : listed(call, list);
  if (segments.length > 2) return row;
  switch (method) {
    case "POST":
      return (
        taken(call) ??
        added(world, rows, {
          ...sampleOf(
            operationFor("GET", `/${segments[0]}/x`).operation.response(200).content["application/json"].schema,
          ),
          ...body,
        })
      );
    case "DELETE":
      rows.splice(rows.indexOf(row), 1);
      return undefined;
    default:
      return taken(call) ?? Object.assign(row, body);
  }
}

// Logins and names are not given twice.
function taken({ rows, row, body }) {
  const key = ["login", "name"].find((name) => body[name] !== undefined);
  const other = key && rows.some((each) => each !== row && each[key] === body[key]);
  return other ? conflict(`${key}: expected one that nobody has`, key) : undefined;
}

// The name of the list that an answer is.
function listIn({ content }) {
  const { properties } = content?.["application/json"]?.schema ?? {};
  const lists = Object.keys(properties ?? {}).filter((name) => properties[name].type === "array");
  return Object.keys(properties ?? {}).every((name) => name === "next" || lists.includes(name)) && lists.length === 1
    ? lists[0]
    : undefined;
}

const kOthers = { live: "attempts", "tooth-imports": "imports", "exercise-trials": "trials" };
const kCollections = Object.fromEntries(
  operations
    .filter(({ method, segments }) => method === "GET" && segments.length === 1)
    .map(({ segments: [segment], response }) => [segment, listIn(response(200))])
    .filter(([, list]) => list !== undefined),
);
const collectionOf = (segment) => kCollections[segment] ?? kOthers[segment] ?? segment;

const isVisible = (call, row, collection = call.collection) => visible[collection]?.(row, call) ?? true;
const viewOf = (call, row, collection = call.collection) => views[collection]?.(row, call) ?? row;

const one = (collection) => (collection === "people" ? "person" : collection.replace(/s$/, ""));
const belongsTo = (row, name, id) => [row[name], row[`${name}_id`], row[name]?.id].includes(id);

// Rows of a list, or of one that belongs to a thing, narrowed by the query, page by page.
function listed(call, list) {
  const { query, id, row, world, collection } = call;
  const own =
    row?.[list] ??
    (row === undefined ? world[list] : world[list].filter((each) => belongsTo(each, one(collection), id)));
  const { cursor, limit, ...narrowed } = query;
  const asked = Object.entries(narrowed).filter(([, value]) => value !== undefined);
  const rows = own.filter(
    (each) =>
      isVisible(call, each, list) &&
      asked.every(([name, value]) => filters[list]?.[name]?.(each, value, call) ?? belongsTo(each, name, value)),
  );
  const keyOf = (each) => each.id ?? each.name ?? String(rows.indexOf(each));
  const first = cursor === undefined ? 0 : rows.findIndex((each) => keyOf(each) === cursor) + 1;
  const shown = rows.slice(first, first + (limit ?? rows.length));
  return {
    [list]: shown.map((each) => viewOf(call, each, list)),
    next: first + shown.length < rows.length ? keyOf(shown.at(-1)) : null,
  };
}

// As bytes, when it is what the contract says.
function sent(call, result) {
  const reply = result instanceof Reply ? result : new Reply(result);
  const { operation, row } = call ?? {};
  const status = reply.status ?? operation.status;
  const { content, headers: known } = operation?.response(status) ?? {};
  const schema = content?.["application/json"]?.schema;
  if (operation !== undefined && !operation.known(status))
    throw new Error(`the contract has no ${status} for ${operation.route}`);
  if (status === 204) return { status, headers: reply.headers };
  if (schema === undefined && operation !== undefined)
    return {
      status,
      headers: { "Content-Type": Object.keys(content ?? {})[0] ?? "", "Cache-Control": "no-store", ...reply.headers },
      body: reply.body,
      stream: reply.stream,
    };
  const told = call?.rows?.includes(reply.body) ? viewOf(call, reply.body) : reply.body;
  const body =
    schema === undefined ? told : status >= 400 ? { ...told, ...fitted(schema, told) } : fitted(schema, told);
  const problem = schema && problemOf(schema, body);
  if (problem !== undefined)
    throw new Error(`breaks the contract of ${operation.route}, ${status}: ${problem.message}`);
  const tag = known?.ETag === undefined ? {} : { ETag: `"${reply.tag ?? body.revision ?? row?.revision}"` };
  return {
    status,
    headers: { "Content-Type": "application/json", "Cache-Control": "no-store", ...tag, ...reply.headers },
    body: JSON.stringify(body),
  };
}

const cookieOf = (request) => /(?:^|;\s*)enamel_session=([0-9a-f]+)/.exec(request.headers.cookie ?? "")?.[1];

function typed({ type }, text) {
  return type === "integer" ? Number(text) : type === "boolean" ? text === "true" : text;
}

async function readBody(request) {
  const chunks = [];
  for await (const chunk of request) chunks.push(chunk);
  return Buffer.concat(chunks);
}

function parsed(bytes) {
  try {
    return JSON.parse(bytes.toString());
  } catch {
    return undefined;
  }
}

function pageFile(dist, request, path) {
  const file = normalize(join(dist, path));
  const above = join(dirname(file), "index.html");
  const found =
    [file, above].find((each) => each.startsWith(normalize(dist)) && existsSync(each) && statSync(each).isFile()) ??
    join(dist, "index.html");
  const packed = (request.headers["accept-encoding"] ?? "").includes("br") && existsSync(`${found}.br`);
  return {
    status: 200,
    body: readFileSync(packed ? `${found}.br` : found),
    headers: {
      "Content-Type": kTypes[extname(found)] ?? "application/octet-stream",
      Vary: "Accept-Encoding",
      "Cache-Control": found.endsWith("index.html") ? "no-cache" : "public, max-age=31536000, immutable",
      ...(packed ? { "Content-Encoding": "br" } : {}),
    },
  };
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [, , dist, port] = process.argv;
  if (dist === undefined) throw new Error("expected the folder of the built page: node mock_server.mjs DIST [PORT]");
  const { url } = await startMockServer({ dist, port: Number(port ?? 0) });
  console.log(url);
  for (const { role, login, password } of people) console.log(`${role}: ${login} / ${password}`);
}
