// watch.mjs HTTP_PORT LOGIN PASSWORD SECONDS: signs in, waits for an attempt being made, watches it for SECONDS and prints
// {"rows", "attempt_s", "rows_per_second"}: different moments that a viewer got, and the time of the attempt they are of (at
// 1 kHz: a slow machine makes fewer ticks, and is to be watched all the same).
const [port, login, password, seconds] = [process.argv[2], process.argv[3], process.argv[4], Number(process.argv[5])];
const base = `http://127.0.0.1:${port}`;
const signIn = await fetch(`${base}/api/v1/session`, {
  method: "POST", headers: { "content-type": "application/json", origin: base }, body: JSON.stringify({ login, password }),
});
if (!signIn.ok) throw new Error(`sign-in: ${signIn.status} ${await signIn.text()}`);
const cookie = signIn.headers.get("set-cookie").split(";")[0];
const get = (path) => fetch(base + path, { headers: { cookie } });

let attempt;
for (let i = 0; i < 600 && !attempt; ++i) {
  const list = await (await get("/api/v1/attempts?limit=100")).json();
  attempt = (list.items ?? list.attempts ?? list).find((a) => a.state === "recording");
  if (!attempt) await new Promise((done) => setTimeout(done, 50));
}
if (!attempt) throw new Error("no attempt is being made");
const live = await get(`/api/v1/attempts/${attempt.id}/live`);
if (!live.ok) throw new Error(`live: ${live.status} ${await live.text()}`);
const ticks = new Set();
let text = "", first = 0;
const stop = setTimeout(() => process.exit(1), seconds * 4000 + 20000);
for await (const bytes of live.body) {
  text += new TextDecoder().decode(bytes);
  const events = text.split("\n\n");
  text = events.pop();
  for (const event of events) {
    const data = event.split("\n").find((line) => line.startsWith("data: "));
    if (!event.includes("event: ticks") || !data) continue;
    // What was there before is not of this stream's rate.
    const rows = JSON.parse(data.slice(6)).rows;
    const now = performance.now() / 1000;
    if (first === 0) { first = now; continue; }
    for (const row of rows) ticks.add(row[0]);
  }
  if (first > 0 && performance.now() / 1000 - first > seconds) break;
}
clearTimeout(stop);
const attempt_s = (Math.max(...ticks) - Math.min(...ticks)) / 1000;
console.log(JSON.stringify({ rows: ticks.size, attempt_s, rows_per_second: ticks.size / attempt_s }));
process.exit(0);
