import type { AuditEntry } from "../../api/types";
import { formatDateTime, formatNumber } from "../../base/format";

// What an entry of the audit says, as people read it.

// What was done, after the name of who did it. What the page does not know is shown by its own name.
const kActions: Readonly<Record<string, string>> = {
  "annotation.add": "added a remark to", "annotation.edit": "changed a remark of", "annotation.delete": "deleted a remark of",
  "appeal.file": "appealed against the score of", "appeal.answer": "answered the appeal against",
  "assignment.add": "assigned an exercise", "assignment.edit": "changed an assignment", "assignment.move": "moved an assignment to another version", "assignment.delete": "deleted an assignment",
  "attempt.accept": "accepted", "attempt.awaits": "waits for", "attempt.excuse": "excused", "attempt.fail": "could not score", "attempt.flag": "flagged", "attempt.restore": "made an earlier score count again of",
  "attempt.unflag": "took the excuse back of",
  "attempt.override": "set another score of", "attempt.quarantine": "set aside", "attempt.release": "released the score of", "attempt.rescore": "asked to score again",
  "attempt.retention": "removed the recording of", "attempt.return": "took back the ticket of", "attempt.score": "scored", "attempt.seal": "received all of",
  "attempt.ticket": "gave out a ticket for", "attempt.unrelease": "took back the released score of",
  "cohort.add": "added somebody to a cohort", "cohort.create": "made a cohort", "cohort.edit": "changed a cohort", "cohort.remove": "took somebody out of a cohort",
  "device.list": "put a device on the school's list", "device.unlist": "took a device off the school's list",
  "exercise.discard": "discarded a draft", "exercise.draft": "wrote a draft", "exercise.publish": "published an exercise", "exercise.retire": "retired an exercise",
  "exercise.rubric": "changed how an exercise is scored", "exercise.share": "changed who may use an exercise",
  "job.cancel": "cancelled the scoring of",
  "person.create": "added", "person.disable": "shut out", "person.edit": "changed the account of", "person.enable": "let in again", "person.erase": "erased",
  "person.export": "exported the data of", "person.password": "set a new password for",
  "profile.calibration": "added a calibration to", "profile.put": "changed the device profile", "profile.report": "added a report to",
  "reference.add": "made a reference of", "reference.withdraw": "withdrew a reference", "request.refused": "was refused a request", "retention.set": "changed a retention rule",
  "roster.import": "imported a roster", "scene.put": "put a scene", "session.begin": "signed in", "session.end": "ended a session of", "session.refused": "was turned away at the sign-in of",
  "station.code": "made an enrolment code", "station.code_withdrawn": "withdrew an enrolment code", "station.enrol": "enrolled", "station.enrol_again": "enrolled again",
  "station.rename": "renamed a station", "station.revoke": "revoked a station", "store.backup": "made a backup",
};

export function actionText(action: string): string {
  return kActions[action] ?? action;
}

const kHash = /\b[0-9a-f]{64}\b/g;
const kUuid = /[0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12}/;

// "UUID (page)": the person, and by what way.
export function personOf(actor: string): string | undefined {
  return new RegExp(`^${kUuid.source}(?= |$)`).exec(actor)?.[0];
}

const kOnAttempts = ["attempt", "annotation", "appeal", "job"];

export interface Thing {
  readonly kind: "attempt" | "person" | "other";
  readonly id: string;
  readonly text: string;                        // where no better name is known
}

// What it was done to; undefined where the sentence needs none.
export function thingOf({ action, object }: Pick<AuditEntry, "action" | "object">): Thing | undefined {
  const [area = ""] = action.split(".");
  if (object === "" || (action === "session.begin")) return undefined;
  if (kOnAttempts.includes(area)) return { kind: "attempt", id: object, text: `attempt ${shortId(object)}` };
  if (area === "person" || area === "session") return { kind: "person", id: object, text: shortId(object) };
  return { kind: "other", id: object, text: shortId(object) };
}

// The end of an id tells things apart; its beginning is a time.
export function shortId(text: string): string {
  return text.replace(new RegExp(kUuid, "g"), (id) => `…${id.slice(-6)}`).replace(kHash, (hash) => `${hash.slice(0, 8)}…`);
}

// Everyone whose name a reader wants, each once.
export function peopleIn(entries: readonly AuditEntry[]): string[] {
  const ids = entries.flatMap((entry) => {
    const thing = thingOf(entry);
    return [personOf(entry.actor) ?? [], thing?.kind === "person" && personOf(thing.id) !== undefined ? thing.id : [], membersIn(entry)].flat();
  });
  return [...new Set(ids)].sort();
}

function membersIn({ before, after }: AuditEntry): string[] {
  return [before, after].flatMap((text) => { const person = membersOf(text)["person"]; return typeof person === "string" && personOf(person) !== undefined ? [person] : []; });
}

export interface Detail {
  readonly name: string;
  readonly before: string;                      // empty: there was nothing
  readonly after: string;                       // empty: nothing is left
}

// What changed, member by member. What stayed, what is empty and what holds nothing is left out.
export function detailsOf({ before, after }: Pick<AuditEntry, "before" | "after">, nameOf: (id: string) => string = shortId): Detail[] {
  const [was, is] = [membersOf(before), membersOf(after)];
  return [...new Set([...Object.keys(was), ...Object.keys(is)])].flatMap((key) => {
    const [old, now] = [valueText(key, was[key], nameOf), valueText(key, is[key], nameOf)];
    return old === now ? [] : [{ name: nameText(key), before: old, after: now }];
  });
}

function membersOf(text: string): Readonly<Record<string, unknown>> {
  if (text === "") return {};
  try {
    const value: unknown = JSON.parse(text);
    return typeof value === "object" && value !== null && !Array.isArray(value) ? value as Readonly<Record<string, unknown>> : { value };
  } catch {
    return { value: text };
  }
}

function nameText(key: string): string {
  const words = key.replace(/_ms$/, "").replaceAll("_", " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}

function valueText(key: string, value: unknown, nameOf: (id: string) => string): string {
  if (value === undefined || value === null || value === "" || (key.endsWith("_ms") && Number(value) === 0)) return "";
  if (key.endsWith("_ms") && Number.isFinite(Number(value))) return formatDateTime(Number(value));
  if (typeof value === "boolean") return value ? "yes" : "no";
  if (typeof value === "string" && /^-?\d+\.\d+$/.test(value)) return formatNumber(Number(value), 3);
  if (typeof value === "string") return personOf(value) === value ? nameOf(value) : shortId(value);
  if (Array.isArray(value)) return value.length === 0 ? "" : value.map((item) => valueText("", item, nameOf)).join(", ");
  return typeof value === "object" ? (Object.keys(value).length === 0 ? "" : shortId(JSON.stringify(value))) : String(value);
}
