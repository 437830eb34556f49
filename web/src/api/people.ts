import { ok } from "../base/result";
import { type ApiResult, type Http, queryText, segment } from "./http";
import type {
  Cohort,
  ErasureReport,
  FirstAdmin,
  ListedCohort,
  PersonDetail,
  PersonWithCohorts,
  PersonWithPassword,
  Role,
  RosterOutcome,
  SessionEntry,
} from "./types";

export interface RosterImport {
  readonly cohort: string; // of rows without one; empty: none
  readonly reading: RosterOutcome["reading"] | undefined; // of the bytes; undefined: the server recognises it
  readonly ignoreUnknown: boolean; // columns
  readonly move: boolean; // students who join a cohort leave their other ones
}

export interface PeopleQuery {
  readonly text?: string | undefined;
  readonly role?: string | undefined;
  readonly cohort?: string | undefined;
  readonly cursor?: string | undefined;
  readonly limit?: number | undefined;
}

// People, their sessions and cohorts.
export class PeopleApi {
  constructor(private readonly http: Http) {}

  // With the token of the link that a new server prints; nobody is signed in.
  makeFirstAdmin(admin: FirstAdmin) {
    return this.http.json<PersonDetail>("POST", "/first-admin", { body: admin, signingIn: true });
  }
  list(query: PeopleQuery, signal?: AbortSignal) {
    return this.http.page<PersonDetail>("/people", "people", { ...query }, signal);
  }
  get(id: string, signal?: AbortSignal) {
    return this.http.tagged<PersonWithCohorts>("GET", personPath(id), { signal });
  }
  create(person: { readonly login: string; readonly display_name: string; readonly role: Role }) {
    return this.http.json<PersonWithPassword>("POST", "/people", { body: person });
  }
  edit(id: string, change: Partial<Pick<PersonDetail, "display_name" | "role" | "disabled">>, tag: string) {
    return this.http.tagged<PersonDetail>("PATCH", personPath(id), { body: change, tag });
  }
  resetPassword(id: string) {
    return this.http.json<PersonWithPassword>("POST", `${personPath(id)}/password`);
  }
  sessions(id: string, signal?: AbortSignal) {
    return this.http.all<SessionEntry>(`${personPath(id)}/sessions`, "sessions", {}, signal);
  }
  // Cannot be undone; the login is repeated for that.
  erase(id: string, login: string, withReferences: boolean) {
    return this.http.json<ErasureReport>("POST", `${personPath(id)}/erase`, {
      body: { login, with_references: withReferences },
    });
  }
  endSessions(id: string) {
    return this.http.json<{ ended: number }>("DELETE", `${personPath(id)}/sessions`);
  }
  ownSessions(signal?: AbortSignal) {
    return this.http.all<SessionEntry>("/sessions", "sessions", {}, signal);
  }
  // One's own, or as an admin anybody's.
  endSession(session: string) {
    return this.http.empty("DELETE", `/sessions/${segment(session)}`);
  }
  // It signs exams at a chair.
  choosePin(pin: string) {
    return this.http.empty("PUT", "/session/pin", { body: { pin } });
  }
  // With `trial` nothing is changed: the answer says what would be. A roster with problems is
  // refused as a whole; the report then says what they are.
  async importRoster(bytes: ArrayBuffer, how: RosterImport, trial: boolean): Promise<ApiResult<RosterOutcome>> {
    const query = queryText({
      dry_run: trial,
      cohort: how.cohort,
      reading: how.reading,
      unknown_columns: how.ignoreUnknown ? "ignore" : undefined,
      other_cohorts: how.move ? "leave" : undefined,
    });
    const result = await this.http.json<RosterOutcome>("POST", `/roster${query}`, {
      body: bytes,
      type: "application/octet-stream",
    });
    if (!result.ok && Array.isArray(result.error.answer?.["problems"]))
      return ok(result.error.answer as unknown as RosterOutcome);
    return result;
  }

  cohorts(
    query: { readonly archived?: boolean; readonly cursor?: string | undefined; readonly limit?: number },
    signal?: AbortSignal,
  ) {
    return this.http.page<ListedCohort>("/cohorts", "cohorts", { ...query }, signal);
  }
  allCohorts(signal?: AbortSignal) {
    return this.http.all<ListedCohort>("/cohorts", "cohorts", {}, signal);
  }
  cohort(id: string, signal?: AbortSignal) {
    return this.http.tagged<Cohort>("GET", cohortPath(id), { signal });
  }
  addCohort(name: string) {
    return this.http.json<Cohort>("POST", "/cohorts", { body: { name } });
  }
  editCohort(id: string, change: { readonly name?: string; readonly archived?: boolean }, tag: string) {
    return this.http.tagged<Cohort>("PATCH", cohortPath(id), { body: change, tag });
  }
  addMember(id: string, person: string) {
    return this.http.json<Cohort>("POST", `${cohortPath(id)}/members`, { body: { add: [person] } });
  }
  removeMember(id: string, person: string) {
    return this.http.json<Cohort>("POST", `${cohortPath(id)}/members`, { body: { remove: [person] } });
  }
}

function personPath(id: string): string {
  return `/people/${segment(id)}`;
}

function cohortPath(id: string): string {
  return `/cohorts/${segment(id)}`;
}
