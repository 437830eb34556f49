import { type Ahead, attemptPath, scorePath, timelinePath } from "./ahead";
import { checkSeries, checkTicks } from "./series";
import { type ApiResult, type Fetch, Http, segment, understood } from "./http";
import { MarkingApi } from "./marking";
import { PeopleApi } from "./people";
import { TeachingApi } from "./teaching";
import { OperationsApi, ProfilesApi, StationsApi } from "./things";
import type {
  Attempt,
  AttemptDetail,
  AttemptFlag,
  AttemptState,
  LiveRemark,
  LiveRemarks,
  Score,
  Series,
  Session,
  Ticks,
} from "./types";

export interface AttemptQuery {
  readonly cohort?: string | undefined;
  readonly exercise?: string | undefined;
  readonly person?: string | undefined;
  readonly assignment?: string | undefined;
  readonly state?: AttemptState | undefined;
  readonly flag?: AttemptFlag | undefined;
  readonly appeal?: "open" | undefined;
  readonly name?: string | undefined;
  readonly order?: "name" | "lowest_score" | undefined;
  readonly cursor?: string | undefined;
  readonly limit?: number | undefined;
}

interface NextOne {
  readonly id: string;
  series: Promise<ApiResult<Series>> | undefined;
}

// The server's HTTP API (schemas/api/openapi.yaml). Never throws: every outcome is a Result.
// `sessionLost` is called when a request needs a session and the server reports none.
export class Client {
  readonly teaching: TeachingApi;
  readonly marking: MarkingApi;
  readonly people: PeopleApi;
  readonly stations: StationsApi;
  readonly profiles: ProfilesApi;
  readonly operations: OperationsApi;
  readonly http: Http; // for what only one page asks
  private ahead: NextOne | undefined; // of one attempt at most

  // `ahead`: what was asked for before this was there.
  constructor(sessionLost: () => void, send?: Fetch, ahead?: Ahead) {
    this.http = new Http(sessionLost, send, ahead);
    this.teaching = new TeachingApi(this.http);
    this.marking = new MarkingApi(this.http);
    this.people = new PeopleApi(this.http);
    this.stations = new StationsApi(this.http);
    this.profiles = new ProfilesApi(this.http);
    this.operations = new OperationsApi(this.http);
  }

  async signIn(login: string, password: string): Promise<ApiResult<Session>> {
    this.http.ahead.forget();
    return this.keepCsrf(
      await this.http.json<Session>("POST", "/session", { body: { login, password }, signingIn: true }),
    );
  }

  // Who is signed in already, if anybody: a missing session is an answer here, not a loss.
  async currentSession(): Promise<ApiResult<Session>> {
    return this.keepCsrf(await this.http.json<Session>("GET", "/session", { signingIn: true }));
  }

  async signOut(): Promise<ApiResult<undefined>> {
    const result = await this.http.empty("DELETE", "/session");
    if (result.ok) this.http.csrf = "";
    return result;
  }

  // Ends every session of this person and begins another, with a csrf value of its own.
  async changePassword(old: string, fresh: string): Promise<ApiResult<Session>> {
    return this.keepCsrf(
      await this.http.json<Session>("POST", "/session/password", { body: { old_password: old, new_password: fresh } }),
    );
  }

  // In which language this person reads the page; empty: the browser's.
  setLanguage(language: Session["language"]): Promise<ApiResult<Session>> {
    return this.http.json<Session>("PUT", "/session/language", { body: { language } });
  }

  // `ask` is called when a change needs the password again: it shows the question, calls
  // confirmPassword and says whether that went well.
  onConfirmPassword(ask: () => Promise<boolean>): void {
    this.http.confirmPassword = ask;
  }

  // A wrong password is an answer here, not a lost session.
  confirmPassword(password: string) {
    return this.http.empty("POST", "/session/confirm", { body: { password } });
  }

  // Newest first.
  attempts(query: AttemptQuery, signal?: AbortSignal) {
    return this.http.page<Attempt>("/attempts", "attempts", { ...query }, signal);
  }
  attempt(id: string, signal?: AbortSignal) {
    return this.http.json<AttemptDetail>("GET", attemptPath(id), { signal });
  }
  // In the server's words: wordedScore (worded.ts) has those of the page.
  score(id: string, signal?: AbortSignal) {
    return this.http.json<Score>("GET", scorePath(id), { signal, kept: true });
  }
  async series(id: string, signal?: AbortSignal): Promise<ApiResult<Series>> {
    const ahead = await this.takeAhead(id);
    return ahead?.ok === true ? ahead : this.askSeries(id, signal);
  }
  // Of the recording itself: at most 4000 ticks of time.
  async ticks(id: string, from: number, to: number, signal?: AbortSignal): Promise<ApiResult<Ticks>> {
    const result = await this.http.json<unknown>("GET", `${attemptPath(id)}/ticks?from=${from}&to=${to}`, { signal });
    return result.ok ? understood(checkTicks(result.value)) : result;
  }
  // What is shown where nothing can be played back: some megabytes.
  surface(id: string, signal?: AbortSignal): Promise<ApiResult<ArrayBuffer>> {
    return this.http.bytes(`${attemptPath(id)}/surface`, signal);
  }
  // Reads the series of an attempt that will probably be opened next. It is given out once; a
  // failure is asked again.
  readAhead(id: string): void {
    if (this.ahead?.id !== id) this.ahead = { id, series: this.askSeries(id) };
  }
  private takeAhead(id: string): NextOne["series"] {
    if (this.ahead?.id !== id) return undefined;
    const found = this.ahead.series;
    this.ahead.series = undefined;
    return found;
  }
  private async askSeries(id: string, signal?: AbortSignal): Promise<ApiResult<Series>> {
    const result = await this.http.json<unknown>("GET", `${attemptPath(id)}/series`, { signal, kept: true });
    return result.ok ? understood(checkSeries(result.value)) : result;
  }
  // The attempt's timeline (tooth/timeline.ts), from `from` to before `to`, as it comes.
  timeline(id: string, from: number, to: number, signal?: AbortSignal) {
    return this.http.stream(timelinePath(id), from, to, signal);
  }
  // Of the tooth at the timeline's end from the reference (tooth/deviation.ts). Not found: there is
  // none to compare with.
  deviation(id: string, signal?: AbortSignal): Promise<ApiResult<ArrayBuffer>> {
    return this.http.kept(`${attemptPath(id)}/deviation`, signal);
  }
  // The tooth before it was cut (tooth/interior.ts), which never changes; `hash`: as the timeline's head has it.
  startTooth(hash: string): Promise<ApiResult<ArrayBuffer>> {
    return this.http.kept(`/start-teeth/${hash}`);
  }
  // What was said to the chair of an attempt that is being made, and saying something.
  liveRemarks(id: string, signal?: AbortSignal) {
    return this.http.json<LiveRemarks>("GET", `/live/${segment(id)}/remarks`, { signal });
  }
  sendLiveRemark(id: string, text: string) {
    return this.http.json<LiveRemark>("POST", `/live/${segment(id)}/remarks`, { body: { text } });
  }
  private keepCsrf(result: ApiResult<Session>): ApiResult<Session> {
    if (result.ok) this.http.csrf = result.value.csrf;
    return result;
  }
}

// A tar archive that proves the score without this server (schemas/result.md, "Files").
export const signedResultAddress = (id: string) => `/api/v1${attemptPath(id)}/signed-result`;
