import type { Client } from "../../api/client";
import type { Asked } from "../../api/contract";
import { reported } from "../../api/http";
import type { RosterOutcome } from "../../api/types";
import type { Option } from "../../widgets/form";
import { say } from "../../base/words";

export type RosterReading = RosterOutcome["reading"];
export type Others = "" | "keep" | "leave"; // empty: not chosen yet

export interface RosterImport {
  readonly cohort: string; // of rows without one; empty: none
  readonly reading: RosterReading | undefined; // of the bytes; undefined: the server recognises it
  readonly ignoreUnknown: boolean; // columns
  readonly move: boolean; // students who join a cohort leave their other ones
}

// With `trial` nothing is changed: the answer says what would be. A roster with problems is
// refused as a whole; the report then says what they are.
export function importRoster(client: Client, body: ArrayBuffer, how: RosterImport, trial: boolean) {
  const asked: Asked<"POST", "/roster"> = {
    dry_run: trial,
    cohort: how.cohort,
    reading: how.reading,
    unknown_columns: how.ignoreUnknown ? "ignore" : undefined,
    other_cohorts: how.move ? "leave" : undefined,
    body,
    type: "application/octet-stream",
  };
  return reported(client.post("/roster", asked), "problems");
}

export function readings(): readonly Option<RosterReading>[] {
  return [
    { value: "utf-8", title: say("roster.reading_utf_8") },
    { value: "utf-16le", title: say("roster.reading_utf_16le") },
    { value: "utf-16be", title: say("roster.reading_utf_16be") },
    { value: "windows-1252", title: say("roster.reading_windows_1252") },
    { value: "windows-1250", title: say("roster.reading_windows_1250") },
    { value: "windows-1251", title: say("roster.reading_windows_1251") },
    { value: "gb18030", title: say("roster.reading_gb18030") },
  ];
}

// Whether somebody has to say what becomes of students who are in another cohort.
export function asksAboutOthers({ people }: RosterOutcome): boolean {
  return people.some(({ others }) => others.length > 0);
}

export function detailText({ renames, joins, others, note }: RosterOutcome["people"][number], chosen: Others): string {
  const cohorts = others.join(", ");
  return (
    [
      renames ? say("roster.renames") : "",
      joins ? say("roster.joins") : "",
      cohorts === "" ? "" : say(chosen === "leave" ? "roster.leaves" : "roster.also_in", { cohorts }),
      note,
    ]
      .filter((part) => part !== "")
      .join("; ") || "–"
  );
}

export function leftOutText({ left_out: rows }: RosterOutcome): string {
  return say("roster.left_out", {
    rows: rows.map(({ row, text }) => say("roster.left_out_row", { row, text })).join(", "),
  });
}
