// One successful call of each operation about people, cohorts, stations, devices and the server: see run.mjs.
import { rmSync, symlinkSync } from "node:fs";
import { golden } from "./contract.mjs";
import { Person, until } from "./client.mjs";

const kProfile = "phantom_desktop";
const kPassword = "quite a long phrase";

// A tetrahedron of 9 mm. It has no room for a pulp, so its exercises are practice.
const kMesh = `solid t\n${[
  [0, 1, 2],
  [0, 3, 1],
  [0, 2, 3],
  [1, 3, 2],
]
  .map((corners) => {
    const places = [
      [0, 0, 0],
      [9, 0, 0],
      [0, 9, 0],
      [0, 0, 9],
    ];
    const lines = corners.map((corner) => `vertex ${places[corner].join(" ")}\n`).join("");
    return `facet normal 0 0 0\nouter loop\n${lines}endloop\nendfacet\n`;
  })
  .join("")}endsolid t\n`;

const imported = (w) =>
  until(
    "the import is over",
    () => w.admin.ask("GET", `/api/v1/tooth-imports/${w.tooth}`),
    ({ json }) => ["done", "refused"].includes(json.state),
  );
const mesh = (title) => ({
  file_name: "t.stl",
  bytes: kMesh.length,
  unit: "mm",
  title,
  tooth: 46,
  practice: true,
});

export const server = [
  { of: "getAlive", by: "nobody" },
  { of: "getReady", by: "nobody" },
  { of: "getHealth", by: "nobody" },
  { of: "getMetrics", by: "nobody" },
  {
    of: "makeFirstAdmin",
    by: "newcomer",
    body: (w) => ({ token: w.token, login: "first", display_name: "First admin", password: kPassword }),
  },
  { of: "listAudit", by: "admin" },
  { of: "listAudit", by: "admin", query: "?action=person.&limit=2" },
  { of: "startBackup", by: "admin" },
  {
    of: "getServerHealth",
    by: "admin",
    before: (w) =>
      until(
        "the backup is made",
        () => w.admin.ask("GET", "/api/v1/health"),
        ({ json }) => json.backup !== null,
      ),
  },
  // A backup that fails: nothing can be put into this folder.
  {
    of: "getServerHealth",
    by: "admin",
    before: async (w) => {
      rmSync(w.backups, { recursive: true });
      symlinkSync("/proc", w.backups);
      await w.admin.need("POST", "/api/v1/backups");
      await until(
        "the backup has failed",
        () => w.admin.ask("GET", "/api/v1/health"),
        ({ json }) => json.backups.failed !== null,
      );
    },
  },
];

export const people = [
  {
    of: "addCohort",
    by: "admin",
    body: () => ({ name: "Second cohort" }),
    after: (w, { json }) => {
      w.second = json.id;
    },
  },
  {
    of: "addPerson",
    by: "admin",
    body: (w) => ({ login: "ivo", display_name: "Ivo", role: "instructor", cohorts: [w.second] }),
    after: async (w, { json }) => {
      w.once = json.password;
      w.ivo = await Person.signedIn(w.url, "ivo", "ivo", json.password);
    },
  },
  {
    of: "changePassword",
    by: "ivo",
    body: (w) => ({ old_password: w.once, new_password: kPassword }),
    after: (w, answer) => {
      w.ivo.take(answer);
      w.ivo.password = kPassword;
    },
  },
  {
    of: "importRoster",
    by: "admin",
    type: "text/csv",
    body: () =>
      "login,display_name,role,cohort\ntom,Tom,student,Second cohort\nzoe,Zoe,student,Second cohort\nbea,Bea,instructor,Demo cohort\n",
    wrong: [{ body: "nonsense\n1\n", status: 400 }],
    after: async (w, { json }) => {
      for (const { login, password } of json.passwords) {
        const person = await Person.signedIn(w.url, login, login, password);
        const body = { old_password: password, new_password: kPassword };
        person.take(await person.need("POST", "/api/v1/session/password", { body }));
        w[login] = Object.assign(person, { password: kPassword });
      }
    },
  },
  {
    of: "importRoster",
    by: "admin",
    type: "text/csv",
    query: "?dry_run=true",
    body: () => "login,display_name\ntom,Thomas\n,Total: 1\n",
  },
  { of: "listPeople", by: "admin" },
  { of: "getPerson", by: "admin", at: (w) => w.zoe.id },
  {
    of: "editPerson",
    by: "admin",
    at: (w) => w.zoe.id,
    body: () => ({ display_name: "Zoë", role: "student", disabled: false }),
  },
  { of: "listSessionsOf", by: "admin", at: (w) => w.zoe.id },
  { of: "endSessionsOf", by: "admin", at: (w) => w.zoe.id },
  { of: "resetPassword", by: "admin", at: (w) => w.zoe.id },
  { of: "editCohort", by: "admin", at: (w) => w.second, body: () => ({ name: "Cohort of Zoe", archived: false }) },
  { of: "erasePerson", by: "admin", at: (w) => w.zoe.id, body: () => ({ login: "zoe", with_references: false }) },

  {
    of: "signIn",
    by: "guest",
    body: (w) => ({ login: w.sam.login, password: w.sam.password }),
    after: (w, answer) => {
      w.leaving = new Person(w.url, "leaving");
      w.leaving.take(answer);
    },
  },
  { of: "getSession", by: "sam" },
  {
    of: "listSessions",
    by: "sam",
    after: (w, { json }) => {
      w.session = json.sessions.find(({ current }) => !current).id;
    },
  },
  { of: "confirmSession", by: "sam", body: (w) => ({ password: w.sam.password }) },
  { of: "setLanguage", by: "sam", body: () => ({ language: "de" }) },
  { of: "setPin", by: "ben", body: () => ({ pin: "804217" }) },
  { of: "signOut", by: "leaving", alone: true },
  {
    of: "endSession",
    by: "sam",
    before: async (w) => {
      await Person.signedIn(w.url, "other", w.sam.login, w.sam.password);
      const { json } = await w.sam.need("GET", "/api/v1/sessions");
      w.session = json.sessions.find(({ current }) => !current).id;
    },
    at: (w) => w.session,
    mine: ["sam"],
  },

  { of: "listCohorts", by: "ben" },
  { of: "listCohorts", by: "admin", query: "?archived=true" },
  { of: "getCohort", by: "ben", at: (w) => w.demo },
  { of: "editCohort", by: "admin", at: (w) => w.second, body: () => ({ name: "Cohort two", archived: false }) },
  { of: "changeMembers", by: "admin", at: (w) => w.second, body: (w) => ({ add: [w.tom.id], remove: [w.bea.id] }) },
];

export const devices = [
  { of: "listStations", by: "ben" },
  { of: "getStation", by: "ben", at: (w) => w.station },
  { of: "editStation", by: "admin", at: (w) => w.station, body: () => ({ name: "Chair one" }) },
  { of: "addEnrolCode", by: "admin", body: () => ({ minutes: 5 }), after: (w, { json }) => (w.code = json.id) },
  { of: "listEnrolCodes", by: "admin" },
  { of: "withdrawEnrolCode", by: "admin", at: (w) => w.code },
  { of: "listDevice", by: "admin", body: () => ({ name: "hid:1209:0001:7", title: "Chair 7" }) },
  { of: "listListedDevices", by: "ben" },
  { of: "unlistDevice", by: "admin", body: () => ({ name: "hid:1209:0001:7" }) },
  {
    of: "putStationSetting",
    by: "admin",
    body: () => ({ name: "language", scope: "lab2-*", value: "de", fixed: true }),
  },
  { of: "listStationSettings", by: "admin" },
  { of: "removeStationSetting", by: "admin", body: () => ({ name: "language", scope: "lab2-*" }) },

  { of: "listProfiles", by: "sam" },
  {
    of: "getProfile",
    by: "sam",
    at: () => kProfile,
    after: (w, { json }) => {
      w.profile = { ...json.document, title: "Another title" };
    },
  },
  { of: "putProfile", by: "admin", query: "?dry_run=true", body: (w) => w.profile },
  { of: "putProfile", by: "admin", body: (w) => w.profile },
  // With a number and a criterion of every kind.
  { of: "putProfile", by: "admin", alone: true, body: () => golden("scene_profile_torque") },
  { of: "getProfile", by: "ben", alone: true, at: () => golden("scene_profile_torque").name },
  { of: "listProfileVersions", by: "ben", at: () => kProfile },
  {
    of: "addProfileReport",
    by: "admin",
    at: () => kProfile,
    body: () => ({ anything: 1 }),
    after: (w, { json }) => (w.report = json.id),
  },
  { of: "listProfileReports", by: "ben", at: () => kProfile },
  { of: "getProfileReport", by: "ben", at: (w) => w.report },
  { of: "addCalibration", by: "admin", at: () => kProfile, absent: 400, body: () => golden("scene_calibration") },
  { of: "listCalibrations", by: "ben", at: () => kProfile },

  { of: "listBuiltinTeeth", by: "admin" },
  {
    of: "putBuiltinTooth",
    by: "admin",
    body: () => ({ name: "block" }),
    after: (w, { json }) => (w.shapes = json.exercises.map(({ id }) => id)),
  },
  ...[0, 1, 2, 3].map((i) => ({ of: "getExercise", by: "admin", alone: true, at: (w) => w.shapes[i] })),
  ...["ben", "ivo"].map((name) => ({
    of: "editPerson",
    by: "admin",
    alone: true,
    at: (w) => w[name].id,
    body: () => ({ may_import_teeth: true }),
  })),
  { of: "beginToothImport", by: "admin", body: () => mesh("First"), after: (w, { json }) => (w.tooth = json.id) },
  { of: "giveUpToothImport", by: "admin", at: (w) => w.tooth },
  {
    of: "addToothBytes",
    by: "admin",
    before: async (w) => {
      w.tooth = (await w.admin.need("POST", "/api/v1/tooth-imports", { body: mesh("Second") })).json.id;
    },
    at: (w) => w.tooth,
    type: "application/octet-stream",
    body: () => kMesh,
  },
  {
    of: "getToothImport",
    by: "admin",
    before: imported,
    at: (w) => w.tooth,
  },
  {
    of: "getToothImportSurface",
    by: "admin",
    before: async (w) => {
      const begun = await w.admin.need("POST", "/api/v1/tooth-imports", { body: { ...mesh("Third"), publish: false } });
      w.tooth = begun.json.id;
      await w.admin.need("PUT", `/api/v1/tooth-imports/${w.tooth}/bytes`, {
        type: "application/octet-stream",
        body: kMesh,
      });
      await imported(w);
    },
    at: (w) => w.tooth,
  },
  { of: "getToothImportInside", by: "admin", at: (w) => w.tooth },
];

// What nothing else may come after.
export const last = [{ of: "revokeStation", by: "admin", at: (w) => w.station }];
