// say.mjs HTTP_PORT LOGIN PASSWORD TEXT...: signs in, waits for an attempt being made whose station shows remarks, says each
// TEXT at its chair and waits until all were shown. Prints {"attempt", "shown", "kept"}: texts shown, and those that are on the
// attempt as annotations with their tick.
const [port, login, password, ...texts] = process.argv.slice(2);
const base = `http://127.0.0.1:${port}`;
const json = { "content-type": "application/json", origin: base };
const signIn = await fetch(`${base}/api/v1/session`, { method: "POST", headers: json, body: JSON.stringify({ login, password }) });
if (!signIn.ok) throw new Error(`sign-in: ${signIn.status} ${await signIn.text()}`);
const { csrf } = await signIn.json();
const cookie = signIn.headers.get("set-cookie").split(";")[0];
const get = async (path) => (await fetch(base + path, { headers: { cookie } })).json();
const until = async (what, ask) => {
  for (let i = 0; i < 1200; ++i) {
    const found = await ask();
    if (found) return found;
    await new Promise((done) => setTimeout(done, 100));
  }
  throw new Error(`${what}: not within two minutes`);
};

const attempt = await until("an attempt being made", async () =>
  (await get("/api/v1/attempts?state=recording&limit=100")).attempts?.find((a) => a.ticks > 0));
const path = `/api/v1/live/${attempt.id}/remarks`;
await until("a station that shows remarks", async () => (await get(path)).station.shows_remarks);
for (const text of texts) {
  const said = await fetch(base + path, { method: "POST", headers: { ...json, cookie, "x-enamel-csrf": csrf }, body: JSON.stringify({ text }) });
  if (said.status !== 201) throw new Error(`${said.status} ${await said.text()}`);
}
const shown = await until("shown at the chair", async () => {
  const said = (await get(path)).remarks.slice(-texts.length);
  return said.every((remark) => remark.state === "shown") && said;
});
const { annotations } = await get(`/api/v1/attempts/${attempt.id}/annotations`);
console.log(JSON.stringify({ attempt: attempt.id, shown: shown.map((remark) => remark.text), kept: annotations.map(({ text, tick }) => ({ text, tick })) }));
