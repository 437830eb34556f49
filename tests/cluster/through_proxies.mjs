// through_proxies.mjs SERVER_PORT CERTIFICATE NAME=PORT…: through each proxy an admin renames a cohort whose answer the
// proxy has packed, and an instructor watches an attempt that is being made. Prints when the first event came. A proxy
// holds events back when the first comes later than 30 came straight from the server meanwhile, at ten a second.
import { readFileSync } from "node:fs";
import http from "node:http";
import https from "node:https";

const [server, certificate, ...proxies] = process.argv.slice(2);
const kHost = "enamel.test", kMaxHeldBack = 30;
const ca = readFileSync(certificate);
const password = process.env.ENAMEL_PASSWORD;
const fail = (text) => { console.error(text); process.exit(1); };

// Through the proxy at `port`; without one straight to the server, as the proxy asks it.
function send(port, method, path, { headers = {}, body } = {}) {
  const straight = { "X-Forwarded-For": "192.0.2.1", "X-Forwarded-Proto": "https" };
  return new Promise((done, failed) => {
    const options = {
      host: "127.0.0.1", port: port ?? server, method, path: `/api/v1${path}`, ca, servername: kHost, agent: false,
      headers: { Host: port ? `${kHost}:${port}` : kHost, Origin: `https://${kHost}${port ? `:${port}` : ""}`,
                 ...(port ? {} : straight), ...(body ? { "Content-Type": "application/json" } : {}), ...headers },
    };
    (port ? https : http).request(options, done).on("error", failed).end(body && JSON.stringify(body));
  });
}
async function answer(...request) {
  const response = await send(...request);
  const pieces = [];
  for await (const piece of response) pieces.push(piece);
  const bytes = Buffer.concat(pieces);
  if (response.statusCode >= 300) fail(`${request.slice(0, 3).join(" ")}: ${response.statusCode} ${bytes}`);
  return { headers: response.headers, bytes };
}
async function signedIn(port, login) {
  const { headers, bytes } = await answer(port, "POST", "/session", { body: { login, password } });
  return { Cookie: headers["set-cookie"][0].split(";")[0], "X-Enamel-Csrf": JSON.parse(bytes).csrf };
}

async function edit(name, port) {
  const admin = await signedIn(port, "admin");
  const made = JSON.parse((await answer(port, "POST", "/cohorts", { headers: admin, body: { name: `Behind ${name}` } })).bytes);
  const seen = await answer(port, "GET", `/cohorts/${made.id}`, { headers: { ...admin, "Accept-Encoding": "gzip" } });
  const { etag, "content-encoding": coding } = seen.headers;
  if (coding !== "gzip" || !etag.startsWith("W/")) fail(`${name} did not pack: ${coding}, ${etag}`);
  await answer(port, "PATCH", `/cohorts/${made.id}`, { headers: { ...admin, "If-Match": etag }, body: { name: `Renamed behind ${name}` } });
  console.log(`ok: ${name}: renamed over ${etag}`);
}

// Resolves with the milliseconds until the first event; `onEvent` is called for each.
async function watch(port, path, headers, onEvent) {
  const began = performance.now();
  const response = await send(port, "GET", path, { headers });
  if (response.statusCode !== 200) fail(`live: ${response.statusCode}`);
  return new Promise((first) => {
    response.on("error", () => {});
    response.on("data", (bytes) => {
      const events = bytes.toString().split("event: ticks").length - 1;
      for (let i = 0; i < events; ++i) onEvent(response);
      if (events > 0) first(performance.now() - began);
    });
  });
}

async function live(name, port) {
  const through = await signedIn(port, "instructor"), straight = await signedIn(undefined, "instructor");
  let attempt;
  while (!attempt) {
    const { attempts } = JSON.parse((await answer(undefined, "GET", "/attempts?limit=100", { headers: straight })).bytes);
    attempt = attempts.find((each) => each.state === "recording");
  }
  const path = `/attempts/${attempt.id}/live`;
  let held = 0;
  // Its events tell the time: this machine may be slow.
  await watch(undefined, path, straight, () => { ++held; });
  held = 0;
  const first = await watch(port, path, { ...through, "Accept-Encoding": "gzip" }, () => {});
  if (held > kMaxHeldBack) fail(`${name}: the first event came after ${Math.round(first)} ms, when ${held} had come from the server`);
  console.log(`ok: ${name}: first event after ${Math.round(first)} ms`);
}

for (const proxy of proxies) {
  const [name, port] = proxy.split("=");
  await edit(name, port);
  await live(name, port);
}
process.exit(0);
