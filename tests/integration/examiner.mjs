// examiner.mjs BIN WORK PORT EXERCISE KEY: examiner.sh has made the people and the station; here they do their exam. Each step
// says what it found.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { borderline, icc21, phi, phiAt, weightedKappa } from "./examiner_figures.mjs";
import { byPage } from "./examiner_page.mjs";

const [bin, work, port, exercise, key] = process.argv.slice(2);
const password = process.env.ENAMEL_PASSWORD;
const base = `http://127.0.0.1:${port}`;
const kName = "exam-class-1";
const kWaitMs = 600_000;
const ok = (text) => console.log(`ok: ${text}`);

async function until(what, ask) {
  const end = Date.now() + kWaitMs;
  for (;;) {
    const found = await ask();
    if (found) return found;
    assert.ok(Date.now() < end, `${what}: not within ${kWaitMs} ms`);
    await new Promise((next) => setTimeout(next, 200));
  }
}

// A person at the page's interface. `expect`: the status; the answer is the body.
async function signIn(login) {
  const json = { "content-type": "application/json", origin: base };
  const answer = await fetch(`${base}/api/v1/session`, { method: "POST", headers: json, body: JSON.stringify({ login, password }) });
  assert.equal(answer.status, 200, `${login} signs in`);
  const { csrf, person } = await answer.json();
  const headers = { ...json, cookie: answer.headers.get("set-cookie").split(";")[0], "x-enamel-csrf": csrf };
  const send = async (method, path, expect, body, more = {}) => {
    const sent = typeof body === "string" || body === undefined ? body : JSON.stringify(body);
    const got = await fetch(`${base}/api/v1${path}`, { method, headers: { ...headers, ...more }, body: sent });
    const bytes = Buffer.from(await got.arrayBuffer());
    assert.equal(got.status, expect, `${login}: ${method} ${path}: ${bytes.subarray(0, 400)}`);
    const is = got.headers.get("content-type") ?? "";
    return { etag: got.headers.get("etag"), body: is.includes("json") ? JSON.parse(bytes) : bytes };
  };
  return {
    login,
    id: person.id,
    send,
    get: async (path, expect = 200) => (await send("GET", path, expect)).body,
    post: async (path, body, expect = 200, more = {}) => (await send("POST", path, expect, body, more)).body,
  };
}

const station = (args, more = {}) => execFileSync(join(bin, "enamel-station"), args, { stdio: ["ignore", "ignore", "pipe"], ...more });
function cut(person, operator, ...more) {
  const facts = join(work, "cut.json");
  station(["run", "--data", join(work, "station"), "--profile", "phantom_desktop", "--lockstep", "--quiet", "--exercise", kName]
    .concat(["--user", person.login, "--operator", operator, "--json", facts, ...more]));
  return JSON.parse(readFileSync(facts, "utf8")).attempt_id;
}
const scored = (person, attempt) =>
  until(`a score of ${attempt}`, async () => {
    const row = await person.get(`/attempts/${attempt}`);
    assert.notEqual(row.state, "failed", row.problem);
    return row.state === "scored" && row;
  });
async function reference(person, operator, seed) {
  const attempt = cut(person, operator, "--as-reference", "--seed", seed);
  await scored(person, attempt);
  const { version } = await person.post(`/attempts/${attempt}/reference`, { dentist: `Dr ${person.login}`, consent: true }, 201);
  return { attempt, version };
}

const [root, vega, dean, okafor] = [await signIn("root"), await signIn("vega"), await signIn("dean"), await signIn("okafor")];
const students = await Promise.all(Array.from({ length: 10 }, (_, i) => signIn(`s${i + 1}`)));

// A copy of the school's exercise with a material, and an error of the examiner's own that fails an attempt.
async function examExercise() {
  const { exercises } = await vega.get("/exercises?state=published");
  const document = await vega.get(`/exercises/${exercises.find(({ name }) => name === exercise).id}/document`);
  Object.assign(document, { name: kName, title: "Exam in class I" });
  const { rubric } = document;
  Object.assign(rubric, { name: kName, restoration: "composite" });
  const refused = async (change, words) => {
    const wrong = structuredClone(document);
    change(wrong.rubric);
    const { error } = await vega.post("/exercises?dry_run=true", wrong, 400);
    assert.match(error.message, words);
  };
  await refused((r) => {
    r.critical.push({ error: "neighbour_damaged", metric: "neighbour_depth_mm", unit: "mm", above: 0.25, source: "the school" });
  }, /neighbour/);
  await refused((r) => {
    r.restorations = r.restorations.filter(({ restoration }) => restoration !== "composite");
  }, /composite/);
  const draft = await vega.send("POST", "/exercises", 201, document);
  const published = await vega.post(`/exercises/${draft.body.id}/publish`, undefined, 200, { "if-match": draft.etag });
  assert.equal(published.rubric.restoration.name, "composite");
  assert.throws(() => cut(dean, "dentist"), /no exercise/, "it is private");
  await vega.send("PUT", `/exercises/${published.id}/sharing`, 200, { shared: true });
  ok(`rubric: composite, ${published.rubric.critical.length} critical errors`);
  return published;
}

async function twentyAttempts(exam) {
  const cohort = (await vega.get("/cohorts")).cohorts.find(({ name }) => name === "Year 2").id;
  const terms = { exercise: kName, cohort_id: cohort, attempt_limit: 2, hands: "any" };
  assert.equal((await vega.post("/assignments", terms, 409)).error.field, "reference");
  const references = [await reference(vega, "dentist", "1"), await reference(dean, "good", "3")];
  const assignment = (await vega.post("/assignments", terms, 201)).id;
  const hands = ["dentist", "graduate", "student", "fourth-year", "third-year", "second-year", "first-year", "untrained"];
  hands.push("over-extender", "idle");
  const attempts = [];
  for (let i = 0; i < 20; ++i) {
    const who = students[i % 10];
    // Two that cut nothing would be the same work.
    const hand = i === 19 ? "timid" : hands[i % 10];
    const id = cut(who, hand, "--assignment", assignment, "--seed", String(100 + i));
    attempts.push({ ...(await scored(vega, id)), hand, who });
    assert.equal(attempts.at(-1).assignment_id, assignment);
    await who.get(`/attempts/${id}/score`, 403);
  }
  const points = (hand) => attempts.filter((each) => each.hand === hand).map(({ score }) => score.toFixed(1));
  ok(`twenty attempts: ${[...hands, "timid"].map((hand) => `${hand} ${points(hand).join(" ")}`).join(", ")}`);
  assert.equal(exam.graded, true);
  return { cohort, assignment, references, attempts };
}

const scoreOf = (id) => vega.get(`/attempts/${id}/score`);

// A third dentist: nothing changes before somebody asks, nobody loses by it.
async function thirdReference(exam, { cohort, attempts, references }) {
  const before = new Map();
  for (const { id } of attempts) before.set(id, await scoreOf(id));
  references.push(await reference(okafor, "graduate", "5"));
  assert.equal(references.at(-1).version, 3);
  for (const { id } of attempts) assert.deepEqual(await scoreOf(id), before.get(id), "an added reference changes no score");
  const { rubrics } = await vega.get(`/exercises/${exam.id}/rubrics`);
  const preview = await vega.post(`/exercises/${exam.id}/rubrics/preview`, rubrics[0].document);
  const others = preview.attempts.filter((each) => each.other_references).map((each) => each.attempt_id);
  assert.ok(attempts.every(({ id }) => others.includes(id)), "all twenty were measured against two");
  const { id } = await vega.post(`/cohorts/${cohort}/rescore`, { exercise_id: exam.id }, 202);
  await until("scores with three references", async () => {
    const batch = await vega.get(`/batches/${id}`);
    assert.equal(batch.failed, 0);
    return batch.over && batch;
  });
  const judges = new Set();
  let gained = 0;
  for (const { id: attempt } of attempts) {
    await scored(vega, attempt);
    const [old, now] = [before.get(attempt), await scoreOf(attempt)];
    assert.ok(now.score >= old.score && now.points >= old.points, `${old.score} to ${now.score}`);
    assert.equal(now.envelope.references.length, 3);
    assert.equal(old.envelope.references.length, 2);
    judges.add(now.reference_attempt);
    if (now.points > old.points + 0.05) ++gained;
  }
  for (const each of references) {
    await scored(vega, each.attempt);
    assert.equal((await scoreOf(each.attempt)).reference_attempt, each.attempt, "a reference is measured against itself");
  }
  // Empty: the exercise's own target was the kindest.
  assert.ok([...judges].every((each) => each === "" || references.some(({ attempt }) => attempt === each)));
  ok(`a third reference: no score changed before the rescore, then ${gained} of 20 gained and none lost; ${judges.size} cuts judge`);
}

// Failed by the rubric's list.
async function criticalErrors({ attempts }) {
  for (const [hand, error, name] of [["idle", "nothing_cut", "task_done_percent"]]) {
    const { id } = attempts.find((each) => each.hand === hand);
    const score = await scoreOf(id);
    assert.deepEqual([score.acceptance, score.score, score.critical_fail], ["not_acceptable", 0, true], hand);
    const listed = score.critical.some((each) => each.error === error && each.name === name);
    assert.ok(listed, JSON.stringify(score.critical));
    assert.ok(score.points >= 0, "the points without it are beside");
  }
  const fine = await scoreOf(attempts[0].id);
  assert.deepEqual([fine.critical, fine.critical_fail], [[], false]);
  ok("critical error: nothing cut is not acceptable, with the points beside");
}

// An examiner's rating and points, half of a point apart, off by a hand's breadth that is always the same.
function examinersMark(criteria, score, severity, salt) {
  const off = (name) => createHash("sha256").update(salt + name).digest().readUInt8(0) / 255 - 0.5;
  const points = Object.fromEntries(
    criteria.map(({ name, max_points: most }) => {
      const computed = Math.max(0, most - score.criteria.find((each) => each.name === name).lost);
      const given = Math.round(2 * (computed - severity * most + 0.4 * most * off(name))) / 2;
      return [name, { points: Math.min(most, Math.max(0, given)), comment: given < most / 2 ? "Look at this wall." : "" }];
    }),
  );
  const whole = score.critical_fail ? 1 : score.points / 20 + 0.4 - severity * 3 + 1.2 * off("rating");
  return { rating: Math.min(5, Math.max(1, Math.round(whole))), criteria: points };
}

async function blindMarking({ assignment, attempts }, page) {
  const { id: marking } = await vega.post(`/assignments/${assignment}/markings`, { marker_ids: [dean.id, okafor.id] }, 201);
  await vega.post(`/assignments/${assignment}/markings`, { marker_ids: [dean.id, okafor.id] }, 409);
  const path = `/markings/${marking}`;
  // Whose tooth a work is, by its recording: only whoever does not mark can open the attempts.
  const hashOf = (bytes) => createHash("sha256").update(bytes).digest("hex");
  const attemptOf = new Map();
  for (const each of attempts) {
    const bytes = await until("a playback", () => vega.get(`/attempts/${each.id}/timeline`).catch(() => undefined));
    attemptOf.set(hashOf(bytes), each.id);
  }
  const marks = new Map();
  const orders = [];
  for (const [marker, severity] of [[dean, 0.02], [okafor, 0.08]]) {
    const seen = await marker.get(path);
    const told = JSON.stringify(seen);
    for (const { id, who, score } of attempts) {
      assert.ok(!told.includes(id) && !told.includes(who.id) && !told.includes("Candidate"), "no name");
      assert.ok(score === 0 || !told.includes(String(score)), "no score");
    }
    assert.ok(!told.includes("Look at this wall") || seen.comments.length === 0, "no comment of the other's");
    assert.equal(seen.results, null);
    orders.push(seen.mine.map(({ id }) => id));
    assert.equal(seen.mine.length, 20);
    for (const part of ["", "/timeline", "/score", "/surface", "/series", "/ticks", "/signed-result", "/annotations"])
      await marker.get(`/attempts/${attempts[0].id}${part}`, 403);
    const inLists = async () => (await marker.get(`/attempts?assignment=${assignment}&limit=100`)).attempts;
    assert.deepEqual(await inLists(), [], "no list says whose they are");
    await vega.post(`/assignments/${assignment}/release`, undefined, 409); // marks would not be blind
    await marker.get(`/assignments/${assignment}/insight`, 403);
    assert.equal(seen.criteria.some(({ name }) => ["time_s", "force_sent_p95_n"].includes(name)), false);
    for (const [i, { id }] of seen.mine.entries()) {
      const attempt = attemptOf.get(hashOf(await marker.get(`/marking-works/${id}/timeline`)));
      const mark = examinersMark(seen.criteria, await scoreOf(attempt), severity, `${[...attemptOf.values()].indexOf(attempt)} ${marker.login}`);
      if (marks.size === 0) {
        await marker.post(`/marking-works/${attempt}/marks`, mark, 404); // an attempt's id is no work's
        await vega.post(`/marking-works/${id}/marks`, mark, 404); // who does not mark
      }
      // The first by the page, the rest by its interface.
      if (i === 0 && page.marks !== undefined) await page.marks(marker, marking, seen, mark);
      else await marker.post(`/marking-works/${id}/marks`, mark, 204);
      await marker.post(`/marking-works/${id}/marks`, mark, 409); // twice
      marks.set(`${attempt} ${marker.id}`, mark);
    }
    if (marker === dean) {
      const listed = await inLists();
      assert.ok(listed.length === 20 && listed.every((row) => row.score === null && row.computed_score === null));
      assert.equal((await dean.get(`/attempts/${attempts[0].id}`)).score, null, "opened, without its score");
      await dean.get(`/attempts/${attempts[0].id}/score`, 403);
      const { audit } = await root.get("/audit?action=marking.mark&limit=100");
      assert.ok(audit.length === 20 && audit.every(({ after }) => !after.includes("rating")), "nor by the audit trail");
    }
  }
  assert.deepEqual([...orders[0]].sort(), [...orders[1]].sort());
  assert.notDeepEqual(orders[0], orders[1], "each in an order of their own");
  const done = await dean.get(path);
  assert.equal(done.done, true);
  ok("blind marks: 20 by each of two, without names, scores and the other's marks; a mark twice, of an attempt, or by another is refused");
  return { marking, results: done.results, criteria: done.criteria, marks };
}

const near = (found, expected, within, what) => assert.ok(Math.abs(found - expected) <= within, `${what}: ${found}, expected ${expected}`);

function checkFigures({ results, criteria, marks }) {
  const markers = [dean.id, okafor.id];
  for (const { attempt_id: attempt, marks: given } of results.works)
    for (const mark of given) {
      const sent = marks.get(`${attempt} ${mark.marker_id}`);
      assert.equal(mark.rating, sent.rating);
      for (const c of mark.criteria) assert.equal(c.points, sent.criteria[c.name].points);
    }
  const table = (value) => results.works.map((each) => markers.map((id) => value(each.marks.find((mark) => mark.marker_id === id))));
  const [totals, ratings] = [table((mark) => mark.total), table((mark) => mark.rating)];
  const tables = [["total", totals], ["rating", ratings]];
  for (const { name, title } of criteria)
    tables.push([title, table((mark) => mark.criteria.find((each) => each.name === name).points)]);
  let checked = 0;
  for (const [criterion, rows] of tables) {
    const found = results.agreement.find((each) => each.criterion === criterion);
    if (found.icc_2_1.value === null) continue;
    near(found.icc_2_1.value, icc21(rows), 1e-9, `ICC(2,1) of ${criterion}`);
    if (icc21(rows) > 0) near(found.phi.value, phi(rows), 1e-9, `Φ of ${criterion}`);
    ++checked;
  }
  assert.ok(checked > criteria.length / 2, "most criteria have figures");
  const rating = results.agreement.find((each) => each.criterion === "rating");
  near(rating.weighted_kappa.value, weightedKappa(ratings), 1e-9, "weighted kappa");
  const { standard } = results;
  const cut = borderline(results.works.map((each, i) => ({ points: each.computed_score, ratings: ratings[i] })));
  near(standard.borderline.value, cut.value, 1e-6, "the pass mark");
  for (const end of ["low", "high"]) {
    const [least, most] = cut[end];
    const found = standard.borderline[end];
    assert.ok(found >= least && found <= most, `its ${end} end: ${found}, expected ${least} to ${most}`);
  }
  near(standard.phi_at_cut.value, phiAt(totals, standard.borderline.value), 1e-9, "Φ(λ)");
  const [icc] = results.agreement.filter((each) => each.criterion === "total");
  const text = (value) => value.toFixed(3);
  ok(`figures: ICC(2,1) ${text(icc.icc_2_1.value)}, weighted kappa ${text(rating.weighted_kappa.value)}, Φ(λ) ` +
    `${text(standard.phi_at_cut.value)}, pass mark ${cut.value.toFixed(1)} (${standard.borderline.low.toFixed(1)} to ` +
    `${standard.borderline.high.toFixed(1)}, here ${cut.low.map((end) => end.toFixed(1)).join(" … ")} to ${cut.high.map((end) => end.toFixed(1)).join(" … ")}); ${checked} tables recomputed`);
  return { ratings, totals };
}

// From marks on paper: as many as are refused, and as many as are enough.
async function standardFromPaper({ assignment }, { results }) {
  const rows = (works) =>
    ["work,criterion,full_marks,marker,mark"]
      .concat(works.flatMap(({ attempt_id: id, marks }) => marks.map(({ marker_id: who, rating }) => `${id},rating,5,${who},${rating}`)))
      .join("\n");
  const ask = async (works) => (await vega.post(`/assignments/${assignment}/standard`, rows(works), 200, { "content-type": "text/csv" })).borderline;
  const few = await ask(results.works.slice(0, 7));
  assert.equal(few.value, null);
  assert.match(few.why, /needs 8 rated attempts at least, found 7/);
  near((await ask(results.works)).value, results.standard.borderline.value, 1e-6, "the same marks on paper");
  ok(`a pass mark of 7 attempts is refused: ${few.why}`);
}

async function releaseAndAppeal({ assignment, attempts }, page) {
  const before = await students[2].get(`/attempts?assignment=${assignment}&limit=10`);
  assert.ok(before.attempts.every(({ score }) => score === null));
  assert.equal((await vega.post(`/assignments/${assignment}/release`)).released, 20);
  for (const { id, who } of attempts) {
    const seen = await who.get(`/attempts/${id}`);
    assert.equal(seen.score, (await vega.get(`/attempts/${id}`)).score);
    await who.get(`/attempts/${id}/score`);
  }
  const refused = await vega.post(`/assignments/${assignment}/markings`, { marker_ids: [dean.id, okafor.id] }, 409);
  assert.match(refused.error.message, /released/);
  const { id, who } = attempts[2];
  await students[3].get(`/attempts/${id}`, 404);
  const [asked, answered] = ["The mesial wall follows the reference.", "Both examiners looked again: two points more."];
  if (page.appeals !== undefined) await page.appeals(who, id, asked);
  else await who.post(`/attempts/${id}/appeal`, { text: asked }, 201);
  await who.post(`/attempts/${id}/appeal`, { text: "again" }, 409);
  const computed = (await vega.get(`/attempts/${id}`)).computed_score;
  const { etag } = await vega.send("GET", `/attempts/${id}`, 200);
  const given = Number(Math.min(100, computed + 2).toFixed(1)); // as somebody types it
  await vega.send("PUT", `/attempts/${id}/override`, 200, { score: given, reason: answered }, { "if-match": etag });
  const runs = async () => (await vega.get(`/attempts/${id}/results`)).results.length;
  const runsBefore = await runs();
  if (page.answers !== undefined) await page.answers(vega, id, answered);
  else await vega.post(`/attempts/${id}/appeal/answer`, { outcome: "regrade", answer: answered });
  await until("the run that the answer asks for", async () => (await runs()) > runsBefore);
  await scored(vega, id);
  const seen = await who.get(`/attempts/${id}`);
  assert.deepEqual([seen.score, seen.computed_score, seen.appeal.state, seen.appeal.answer], [given, computed, "regraded", answered]);
  const { audit } = await root.get(`/audit?object=${id}&limit=100`);
  const row = (action) => {
    const found = audit.find((each) => each.action === action);
    assert.ok(found !== undefined, `${action} among ${audit.map((each) => each.action).join()}`);
    return JSON.parse(found.after);
  };
  const texts = JSON.stringify([row("appeal.file"), row("attempt.override"), row("appeal.answer")]);
  for (const part of [asked, answered]) assert.ok(texts.includes(part), `${part} in ${texts}`);
  near(Number(row("attempt.override").score), given, 1e-5, "the score that counts, in the audit");
  assert.equal(row("attempt.score").result, seen.result_fingerprint, "the signed result of the computed one, in the audit");
  ok(`appeal: ${computed.toFixed(1)} became ${(given).toFixed(1)}, and the audit has both`);
  return id;
}

// The archive, checked by schemas/verify_result.py alone; then with one bit of each file turned.
async function verifyAlone(attempt) {
  const folder = join(work, "signed");
  mkdirSync(folder);
  writeFileSync(join(work, "signed.tar"), await vega.get(`/attempts/${attempt}/signed-result`));
  execFileSync("tar", ["-xf", join(work, "signed.tar"), "-C", folder]);
  const script = fileURLToPath(new URL("../../schemas/verify_result.py", import.meta.url));
  const verify = () => {
    try {
      return { said: execFileSync("python3", ["-I", script, join(folder, "result.bin"), key], { stdio: "pipe", env: { PATH: process.env.PATH } }).toString() };
    } catch (error) {
      return { refused: error.stderr.toString() };
    }
  };
  const { said, refused } = verify();
  assert.equal(refused, undefined);
  const fingerprint = createHash("sha256").update(readFileSync(join(folder, "result.bin"))).digest("hex");
  assert.ok(said.includes(fingerprint) && /not there: *$/m.test(said), said);
  const files = readdirSync(folder);
  assert.equal(files.length, 11, files.join());
  for (const name of files) {
    const path = join(folder, name);
    const whole = readFileSync(path);
    const turned = Buffer.from(whole);
    turned[Math.floor(turned.length / 2)] ^= 1 << (turned.length % 8);
    writeFileSync(path, turned);
    assert.match(verify().refused ?? "accepted", new RegExp(`REFUSED: ${name.replace(".", "\\.")}`), name);
    writeFileSync(path, whole);
  }
  assert.equal(verify().refused, undefined);
  assert.equal((await vega.get(`/attempts/${attempt}`)).result_fingerprint, fingerprint);
  ok(`verify_result.py accepts ${files.length} files, and refuses each with one bit turned, by its name`);
  return fingerprint;
}

const exam = await examExercise();
const school = await twentyAttempts(exam);
await thirdReference(exam, school);
await criticalErrors(school);
const page = await byPage(base, password);
try {
  const marked = await blindMarking(school, page);
  checkFigures(marked);
  await standardFromPaper(school, marked);
  await page.showsResults?.(dean, marked.marking, marked.results);
  const appealed = await releaseAndAppeal(school, page);
  const fingerprint = await verifyAlone(appealed);
  const failed = school.attempts.find(({ hand }) => hand === "idle").id;
  await page.prints?.(vega, { appealed, fingerprint, failed, score: await scoreOf(appealed), failedScore: await scoreOf(failed) });
} finally {
  await page.close?.();
}
