// Makes a school: people, chairs and attempts, each recorded by enamel-station's simulated hands and scored by
// enamel-server. Every score, reason and playback in it is the server's own.
//   node make.mjs [FOLDER]    FOLDER, else build/release/school, gets `data`, the server's, the chairs' folders, and school.json, which says who is who
// A folder that the same programs and the same scripts made is kept. Takes two minutes of a core. What a key of
// school.json stands for is said where it is made.
import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { existsSync, mkdirSync, readFileSync, renameSync, rmSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { kChairs, kSchool } from "./open.mjs";
import { ended, kPrograms, program, startedServer } from "./programs.mjs";
import { until } from "../../contract/client.mjs";
import { signedInAt } from "./person.mjs";

const kDayMs = 86_400_000;
const kMaxMs = 300_000; // until a loaded machine has scored all
const kVoxelUm = "100"; // the coarsest that every exercise's burs take
const kPin = "804217";
const kGraded = "class-1-molar-46";
const kPractice = `practice-${kGraded}`;
const kUnjudged = "practice-class-2-molar-46-class-2"; // nobody has cut its reference

const kPhantom = "../../../schemas/golden/scene_profile_phantom_desktop.json";

const person = (login, role, name) => ({ login, role, name, password: `a long phrase of ${login}` });
// Four scripts that a sans-serif font of Debian has, twice the same name, and one that is longer than any column.
const kClassNames = [
  "Žofia Kováčová-Szczepańska",
  "Νικόλαος Παπαδόπουλος",
  "Мария Фёдоровна Рождественская",
  "王小明",
  "Nguyễn Thị Minh Khai",
  "محمد عبد الرحمن",
  "Alex Kim",
  "Alex Kim",
  "Maximiliane-Theodora Freifrau von und zu Hohenberg-Wittelsbach-Schwarzenfels",
  "Student Twelve",
];
const kStaff = {
  instructor: person("instructor", "instructor", "Instructor One"),
  colleague: person("colleague", "instructor", "Instructor Two"),
  admin: person("admin", "admin", "Admin One"),
};
const kStudents = {
  student: person("student", "student", "Student One"),
  student2: person("student2", "student", "Student Two"),
};
const kClass = kClassNames.map((name, i) => person(`class${String(i + 3).padStart(2, "0")}`, "student", name));
// One hand each; the last does the same as the one before, at the same chair and after it, so that it is near another.
const kHands = [
  ["fourth-year", 3],
  ["third-year", 4],
  ["second-year", 5],
  ["first-year", 6],
  ["untrained", 8],
  ["timid", 16],
  ["over-extender", 14],
  ["hasty", 12],
  ["good", 31],
  ["good", 31],
];

const folder = resolve(process.argv[2] ?? kSchool);
const making = `${folder}.making`;
const data = join(making, "data");
const said = (text) => console.log(`${(performance.now() / 1000).toFixed(1)} s: ${text}`);
const onServer = (args, options) => program("enamel-server", [...args, "--data", data], options);

async function addPeople() {
  for (const { login, role, name, password } of [...Object.values(kStaff), ...Object.values(kStudents), ...kClass]) {
    const args = ["admin", "add-person", "--login", login, "--role", role, "--name", name, "--password-stdin"];
    await onServer(args, { input: `${password}\n` });
  }
}

async function publish(scene, kind) {
  await onServer([
    "admin",
    "publish-exercise",
    "--scene",
    scene,
    "--voxel-um",
    kVoxelUm,
    "--name",
    kind,
    "--unassigned",
  ]);
}

// The built-in cavity takes a hand three minutes; a smaller one is cut, replayed and looked at in half of one.
async function makeSmaller(admin, name) {
  const { exercises } = await admin.get("/exercises?limit=200");
  const { id } = exercises.find((each) => each.name === name);
  const document = await admin.get(`/exercises/${id}/document`);
  Object.assign(document.target, { half_size_um: [1_000, 800], depth_um: 900 });
  document.instructions = document.instructions.replace("4.0 mm x 2.4 mm, 2.0 mm", "2.0 mm x 1.6 mm, 0.9 mm");
  const draft = await admin.post("/exercises", document);
  await admin.postChanged(`/exercises/${draft.id}`, undefined, "/publish");
}

// A chair, whose attempts come one after the other; two of them work side by side.
async function enrolledChair(link, name) {
  const station = join(making, name);
  const code = (await onServer(["admin", "enrol-code"])).trim();
  await program("enamel-station", ["enrol", "--data", station, "--server", link, "--name", name, "--code", code]);
  let last = Promise.resolve();
  const facts = join(making, `${name}.json`); // of the newest attempt
  const cut = async ({ login, password }, exercise, operator, more) => {
    const args = ["run", "--data", station, "--exercise", exercise, "--lockstep", "--quiet"];
    if (!more.includes("--profile")) args.push("--profile", "phantom_desktop");
    args.push("--user", login, "--operator", operator, "--json", facts, ...more);
    await program("enamel-station", args, { environment: { ENAMEL_PASSWORD: password, ENAMEL_SIGNER_PIN: kPin } });
    return JSON.parse(readFileSync(facts, "utf8")).attempt_id;
  };
  return (...attempt) => {
    const [who, exercise, operator, ...more] = attempt;
    last = last.then(() => cut(who, exercise, operator, more));
    return last;
  };
}

async function fill({ url, link }) {
  const admin = await signedInAt(url, kStaff.admin);
  const teacher = await signedInAt(url, kStaff.instructor);
  const colleague = await signedInAt(url, kStaff.colleague);
  for (const each of [teacher, colleague]) await each.send("PUT")("/session/pin", { pin: kPin });

  const { people } = await admin.get("/people?limit=100");
  const idOf = ({ login }) => people.find((each) => each.login === login).id;
  const cohortOf = async (name, members) => {
    const { id } = await admin.post("/cohorts", { name });
    await admin.post(`/cohorts/${id}/members`, { add: members.map(idOf), remove: [] });
    return id;
  };
  const staff = [kStaff.instructor, kStaff.colleague];
  const everybody = [...Object.values(kStudents), ...kClass];
  const cohorts = {
    first: await cohortOf("Preclinic, first term", [...staff, ...everybody]),
    second: await cohortOf("Preclinic, second term", [...staff, ...everybody.slice(0, 5)]),
  };
  // A device that cannot push as hard as a cut asks for.
  const source = "of no real device";
  await admin.post("/profiles", {
    ...JSON.parse(readFileSync(new URL(kPhantom, import.meta.url), "utf8")),
    name: "weak",
    title: "Weak device",
    peak_force_mn: { value: 400, source },
    continuous_force_mn: { value: 300, source },
  });
  const newcomer = await admin.post("/people", { login: "newcomer", display_name: "Newcomer One", role: "student" });
  for (const name of [kGraded, kPractice]) await makeSmaller(admin, name);
  const { exercises } = await admin.get("/exercises?limit=200");
  const exerciseId = (name) =>
    exercises.filter((each) => each.name === name).sort((a, b) => b.version - a.version)[0].id;

  const [left, right] = await Promise.all(kChairs.map((name) => enrolledChair(link, name)));
  const scored = (who, id) =>
    until(
      `a score of ${id}`,
      () => who.get(`/attempts/${id}`),
      ({ state }) => !["recording", "sealed", "scoring", "ticketed"].includes(state),
      kMaxMs,
    );
  // The reference before has the others scored again, in the server's own time.
  const isBeingScored = (refused) => {
    if (!/: 409 .*is scoring/.test(refused.message)) throw refused;
    return false;
  };
  said("people and chairs are there");

  // Three dentists' cuts of the graded exercise and one of its practice.
  const dentistsCuts = await Promise.all(
    [
      [teacher, left, kGraded, "dentist", "1", "Dentist One"],
      [colleague, right, kGraded, "good", "3", "Dentist Two"],
      [teacher, left, kPractice, "dentist", "1", "Dentist One"],
    ].map(async ([who, chair, exercise, operator, seed, dentist]) => {
      const id = await chair(kStaff[who.login], exercise, operator, "--as-reference", "--seed", seed);
      assert.equal((await scored(who, id)).state, "scored");
      return { who, id, dentist };
    }),
  );
  // One after the other: of two dentists who give the same points, their order decides who judges.
  for (const { who, id, dentist } of dentistsCuts)
    await until(
      `the cut of ${dentist} is a reference`,
      () => who.post(`/attempts/${id}/reference`, { dentist, consent: true }).then(() => true, isBeingScored),
      Boolean,
      kMaxMs,
    );
  const references = { first: dentistsCuts[0].id, second: dentistsCuts[1].id };
  said("references are there");

  const now = Date.now();
  const assign = async (cohort, exercise, terms) =>
    (await teacher.post("/assignments", { exercise, cohort_id: cohorts[cohort], hands: "any", ...terms })).id;
  const assignments = {
    graded: await assign("first", kGraded, { due_ms: now + 4 * kDayMs, attempt_limit: 6 }),
    practice: await assign("first", kPractice, {}),
    exam: await assign("second", kGraded, { exam: true, sign_off: true, due_ms: now + 30 * kDayMs, attempt_limit: 1 }),
    blind: await assign("second", kGraded, {}), // nothing of it is released
    marked: await assign("second", kGraded, {}), // nor of this one, whose blind marking is half done
    unjudged: await assign("second", kUnjudged, {}),
  };

  const under = (assignment) => ["--assignment", assignments[assignment]];
  const seeded = (seed) => ["--seed", String(seed)];
  const { student, student2 } = kStudents;
  const cuts = {
    shown: left(student, kPractice, "student-deep-mesial", ...under("practice")), // seen at once, with remarks
    appealed: right(student2, kGraded, "fourth-year", ...under("graded"), ...seeded(41)),
    released: left(student, kGraded, "student-deep-mesial", ...under("graded")),
    critical: right(student2, kGraded, "clumsy", ...under("graded")),
    unreleased: left(student, kGraded, "student", ...under("graded"), ...seeded(42)),
    // Faster than time, which an exam does not pass: set aside.
    set_aside: right(student2, kGraded, "student", ...under("exam"), "--signer", "instructor", ...seeded(43)),
    // Set aside as well, and then let in by an instructor.
    exam: left(student, kGraded, "third-year", ...under("exam"), "--signer", "instructor", ...seeded(44)),
    exam2: left(kClass[0], kGraded, "second-year", ...under("exam"), "--signer", "colleague", ...seeded(46)),
    blind1: left(kClass[0], kGraded, "untrained", ...under("blind"), ...seeded(47)),
    blind2: right(kClass[1], kGraded, "good", ...under("blind"), ...seeded(48)),
    blind3: left(kClass[2], kGraded, "first-year", ...under("blind"), ...seeded(49)),
    marked1: left(kClass[0], kGraded, "good", ...under("marked"), ...seeded(51)),
    marked2: right(kClass[1], kGraded, "second-year", ...under("marked"), ...seeded(52)),
    waits: right(kClass[1], kUnjudged, "dentist", ...under("unjudged")), // judged by the target alone
    held_back: left(kClass[4], kPractice, "student", ...under("practice"), ...seeded(50), "--profile", "weak"),
    slow: right(student2, kPractice, "good", ...under("practice"), ...seeded(45)),
  };
  for (const [i, [hand, seed]] of kHands.entries())
    cuts[`class${i + 3}`] = (i % 2 === 0 || i === kHands.length - 1 ? left : right)(
      kClass[i],
      kGraded,
      hand,
      ...under("graded"),
      ...seeded(seed),
    );
  const attempts = { reference: references.first, reference2: references.second };
  for (const [name, cut] of Object.entries(cuts)) {
    attempts[name] = await cut;
    said(`${name} is cut`);
  }
  for (const name of ["exam", "exam2"]) {
    await scored(teacher, attempts[name]);
    await teacher.post(`/attempts/${attempts[name]}/rescore`, {});
  }
  for (const [name, id] of Object.entries(attempts)) {
    const { state, problem } = await scored(teacher, id);
    assert.equal(state, { set_aside: "quarantined" }[name] ?? "scored", `${name}: ${problem}`);
  }
  said("all attempts are scored");

  const release = (id) => teacher.postChanged(`/attempts/${id}`, undefined, "/release");
  for (const name of ["released", "appealed", "class3", "class6"]) await release(attempts[name]);
  const owner = await signedInAt(url, student2);
  await owner.post(`/attempts/${attempts.appealed}/appeal`, {
    text: "The mesial wall was cut on purpose: the lesion reached there. Please look at second 20.",
  });
  await teacher.put(`/attempts/${attempts.class4}`, { score: 61.5, reason: "One wall." }, "/override");
  const remark = (id, text, tick, point_um) => teacher.post(`/attempts/${id}/annotations`, { text, tick, point_um });
  await remark(attempts.shown, "Here the bur leans to mesial: keep the handpiece upright.", 9_600, [1_900, 100, 0]);
  await remark(attempts.shown, "Good light touch in the corner.", 30_000, null);
  await remark(attempts.released, "Too deep at this point.", 12_000, [-300, 0, -500]);

  // One of two has marked one of two works.
  const marking = await teacher.post(`/assignments/${assignments.marked}/markings`, {
    marker_ids: [teacher.id, colleague.id],
  });
  const { criteria, mine } = await teacher.get(`/markings/${marking.id}`);
  await teacher.post(`/marking-works/${mine[0].id}/marks`, {
    rating: 3,
    criteria: Object.fromEntries(criteria.map(({ name, max_points }) => [name, { points: max_points / 2 }])),
  });

  // Of all: every copy of the school would make those that are missing, which took 4 s of a processor each time.
  const { attempts: listed } = await admin.get("/attempts?limit=200");
  const whole = listed.filter(({ state }) => state === "scored");
  // One after the other: a person may have six requests under way.
  for (const { id } of whole) {
    await until(
      `playback of ${id}`,
      () => admin.head(`/attempts/${id}/timeline`),
      (status) => status === 200,
      kMaxMs,
    );
  }
  said("playbacks are made");
  const { ticks } = await teacher.get(`/attempts/${attempts.shown}`);
  return {
    people: {
      ...kStaff,
      ...kStudents,
      newcomer: { login: "newcomer", password: newcomer.password, name: "Newcomer One" },
    },
    class: kClass,
    ids: Object.fromEntries([...Object.values(kStaff), ...everybody].map((each) => [each.login, idOf(each)])),
    pin: kPin,
    cohorts,
    exercises: {
      graded: exerciseId(kGraded),
      practice: exerciseId(kPractice),
      unjudged: exerciseId(kUnjudged),
    },
    assignments,
    attempts,
    marking: marking.id,
    shown_ms: ticks,
  };
}

// Of all that decides what is in it.
const madeFrom = createHash("sha256");
for (const name of ["enamel-server", "enamel-station"]) madeFrom.update(readFileSync(join(kPrograms, name)));
for (const name of ["make.mjs", "open.mjs"]) madeFrom.update(readFileSync(new URL(name, import.meta.url)));
const hash = madeFrom.digest("hex");
const kept = join(folder, "school.json");
if (existsSync(kept) && JSON.parse(readFileSync(kept, "utf8")).made_from === hash) {
  console.log(`kept: ${folder} is of the same programs`);
  process.exit(0);
}
rmSync(making, { recursive: true, force: true });
mkdirSync(making, { recursive: true });
await onServer(["init"]);
await addPeople();
await publish("builtin:molar", "class-1");
await publish("builtin:molar-class-2", "class-2");
said("exercises are published");
const dist = join(making, "page");
mkdirSync(dist);
writeFileSync(join(dist, "index.html"), "<!doctype html><title>Enamel</title>");
const server = await startedServer(data, dist, "--job-threads", "2");
try {
  writeFileSync(join(making, "school.json"), JSON.stringify({ made_from: hash, ...(await fill(server)) }, null, 1));
} finally {
  await ended(server.child);
}
await onServer(["verify"]);
rmSync(folder, { recursive: true, force: true });
renameSync(making, folder);
