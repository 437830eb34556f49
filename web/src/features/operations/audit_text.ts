import type { AuditEntry } from "../../api/types";
import { formatDateTime, formatNumber } from "../../base/format";
import { say, sayIf } from "../../base/words";

// What an entry of the audit says, as people read it.

const kHash = /\b[0-9a-f]{64}\b/g;
const kUuid = /[0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12}/;

// "UUID (page)": the person, and by what way.
export function personOf(actor: string): string | undefined {
  return new RegExp(`^${kUuid.source}(?= |$)`).exec(actor)?.[0];
}

// "(station Chair 1)", after the person's name; nothing where they used the page.
export function whereText(actor: string, person: string): string {
  const where = actor.slice(person.length).replace(/^ \((.*)\)$/, "$1");
  const [, station] = /^station (.*)$/.exec(where) ?? [];
  if (where === "" || where === "page") return "";
  return ` ${station === undefined ? `(${where})` : say("audit.at_station", { station })}`;
}

const kOnAttempts = ["attempt", "annotation", "appeal", "job"];

export interface Thing {
  readonly kind: "attempt" | "person" | "other";
  readonly id: string;
  readonly text: string; // where no better name is known
}

// What it was done to; undefined where the sentence needs none.
export function thingOf({ action, object }: Pick<AuditEntry, "action" | "object">): Thing | undefined {
  const [area = ""] = action.split(".");
  if (object === "" || action === "session.begin" || action === "request.refused") return undefined;
  if (kOnAttempts.includes(area))
    return { kind: "attempt", id: object, text: say("audit.attempt", { id: shortId(object) }) };
  if (area === "person" || area === "session") return { kind: "person", id: object, text: shortId(object) };
  return { kind: "other", id: object, text: shortId(object) };
}

// The end of an id tells things apart; its beginning is a time.
export function shortId(text: string): string {
  return text
    .replace(new RegExp(kUuid, "g"), (id) => `…${id.slice(-6)}`)
    .replace(kHash, (hash) => `${hash.slice(0, 8)}…`);
}

// Everyone whose name a reader wants, each once.
export function peopleIn(entries: readonly AuditEntry[]): string[] {
  const ids = entries.flatMap((entry) => {
    const thing = thingOf(entry);
    return [
      personOf(entry.actor) ?? [],
      thing?.kind === "person" && personOf(thing.id) !== undefined ? thing.id : [],
      membersIn(entry),
    ].flat();
  });
  return [...new Set(ids)].sort();
}

function membersIn({ before, after }: AuditEntry): string[] {
  return [before, after].flatMap((text) => {
    const person = membersOf(text)["person"];
    return typeof person === "string" && personOf(person) !== undefined ? [person] : [];
  });
}

export interface Detail {
  readonly name: string;
  readonly before: string; // empty: there was nothing
  readonly after: string; // empty: nothing is left
}

// What changed, member by member. Leaves out unchanged and empty members.
export function detailsOf(
  { before, after }: Pick<AuditEntry, "before" | "after">,
  nameOf: (id: string) => string = shortId,
): Detail[] {
  const [was, is] = [membersOf(before), membersOf(after)];
  return [...new Set([...Object.keys(was), ...Object.keys(is)])].flatMap((key) => {
    if (key === "problem_field") return []; // names the problem
    const text = (members: typeof is) => problemText(key, members) ?? valueText(key, members[key], nameOf);
    const [old, now] = [text(was), text(is)];
    return old === now ? [] : [{ name: nameText(key), before: old, after: now }];
  });
}

// Why an attempt has no score, in words where the server names the reason.
function problemText(key: string, members: Readonly<Record<string, unknown>>): string | undefined {
  const reason = members["problem_field"];
  return key === "problem" && typeof reason === "string" ? sayIf(`refusal.${reason}`) : undefined;
}

function membersOf(text: string): Readonly<Record<string, unknown>> {
  if (text === "") return {};
  try {
    const value: unknown = JSON.parse(text);
    return typeof value === "object" && value !== null && !Array.isArray(value)
      ? (value as Readonly<Record<string, unknown>>)
      : { value };
  } catch {
    return { value: text };
  }
}

function nameText(key: string): string {
  const member = key.replace(/_ms$/, "");
  const known = sayIf(`audit_member.${member}`);
  if (known !== undefined) return known;
  const words = member.replaceAll("_", " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}

// Members whose values are codes, and where their words are.
const kCodes: Readonly<Record<string, readonly string[]>> = {
  cause: ["run_cause"],
  counting: ["counting"],
  flags: ["attempt_flag"],
  hands: ["hands"],
  role: ["role"],
  state: ["attempt_state", "appeal", "exercise_state"],
};

function codeText(key: string, value: string): string | undefined {
  // Of a refusal it is a code; what people typed is none.
  if (key === "reason") return sayIf(`refused_because.${value.replaceAll("-", "_")}`);
  return kCodes[key]?.map((area) => sayIf(`${area}.${value}`)).find(Boolean);
}

function valueText(key: string, value: unknown, nameOf: (id: string) => string): string {
  if (value === undefined || value === null || value === "" || (key.endsWith("_ms") && Number(value) === 0)) return "";
  if (key.endsWith("_ms") && Number.isFinite(Number(value))) return formatDateTime(Number(value));
  if (value === "yes" || value === "no") return say(`common.${value}`);
  const code = typeof value === "string" ? codeText(key, value) : undefined;
  if (code !== undefined) return code;
  if (typeof value === "boolean") return value ? say("common.yes") : say("common.no");
  if (typeof value === "string" && /^-?\d+\.\d+$/.test(value)) return formatNumber(Number(value), 3);
  if (typeof value === "string") return personOf(value) === value ? nameOf(value) : shortId(value);
  if (Array.isArray(value))
    return value.length === 0 ? "" : value.map((item) => valueText("", item, nameOf)).join(", ");
  return typeof value === "object"
    ? Object.keys(value).length === 0
      ? ""
      : shortId(JSON.stringify(value))
    : String(value);
}
