// sign_off.mjs HTTP_PORT LOGIN PASSWORD pin PIN: chooses the PIN that signs exams.
// sign_off.mjs HTTP_PORT LOGIN PASSWORD signatures ATTEMPT: prints who signed start and end, "Name, -".
const [port, login, password, what, value] = process.argv.slice(2);
const base = `http://127.0.0.1:${port}`;
const json = { "content-type": "application/json", origin: base };
const signIn = await fetch(`${base}/api/v1/session`, { method: "POST", headers: json, body: JSON.stringify({ login, password }) });
if (!signIn.ok) throw new Error(`sign-in: ${signIn.status} ${await signIn.text()}`);
const { csrf } = await signIn.json();
const cookie = signIn.headers.get("set-cookie").split(";")[0];
if (what === "pin") {
  const headers = { ...json, cookie, "x-enamel-csrf": csrf };
  const chosen = await fetch(`${base}/api/v1/session/pin`, { method: "PUT", headers, body: JSON.stringify({ pin: value }) });
  if (chosen.status !== 204) throw new Error(`${chosen.status} ${await chosen.text()}`);
} else {
  const { sign_off: signed } = await (await fetch(`${base}/api/v1/attempts/${value}`, { headers: { cookie } })).json();
  console.log([signed.start, signed.end].map((each) => each?.by ?? "-").join(", "));
}
