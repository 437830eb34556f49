import { checkSeries } from "./series";
import { type ApiResult, type Fetch, Http, segment, understood } from "./http";
import { PeopleApi } from "./people";
import { decodeSurface, type Surface } from "./surface";
import { TeachingApi } from "./teaching";
import { OperationsApi, ProfilesApi, StationsApi } from "./things";
import type { Attempt, AttemptDetail, AttemptFlag, AttemptState, Score, Series, Session } from "./types";

export interface AttemptQuery {
  readonly cohort?: string | undefined;
  readonly exercise?: string | undefined;
  readonly person?: string | undefined;
  readonly assignment?: string | undefined;
  readonly state?: AttemptState | undefined;
  readonly flag?: AttemptFlag | undefined;
  readonly appeal?: "open" | undefined;
  readonly cursor?: string | undefined;
  readonly limit?: number | undefined;
}

// The server's HTTP API (schemas/api/openapi.yaml). Never throws: every outcome is a Result.
// `sessionLost` is called when a request that needs a session is told there is none.
export class Client {
  readonly teaching: TeachingApi;
  readonly people: PeopleApi;
  readonly stations: StationsApi;
  readonly profiles: ProfilesApi;
  readonly operations: OperationsApi;
  private readonly http: Http;

  constructor(sessionLost: () => void, send?: Fetch) {
    this.http = new Http(sessionLost, send);
    this.teaching = new TeachingApi(this.http);
    this.people = new PeopleApi(this.http);
    this.stations = new StationsApi(this.http);
    this.profiles = new ProfilesApi(this.http);
    this.operations = new OperationsApi(this.http);
  }

  async signIn(login: string, password: string): Promise<ApiResult<Session>> {
    return this.keepCsrf(await this.http.json<Session>("POST", "/session", { body: { login, password }, signingIn: true }));
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

  // `ask` is called when a change needs the password again: it shows the question, calls
  // confirmPassword and says whether that went well.
  onConfirmPassword(ask: () => Promise<boolean>): void {
    this.http.confirmPassword = ask;
  }

  // A wrong password is an answer here, not a lost session.
  confirmPassword(password: string) {
    return this.http.empty("POST", "/session/confirm", { body: { password }, signingIn: true });
  }

  // Newest first.
  attempts(query: AttemptQuery, signal?: AbortSignal) {
    return this.http.page<Attempt>("/attempts", "attempts", { ...query }, signal);
  }
  attempt(id: string, signal?: AbortSignal) {
    return this.http.json<AttemptDetail>("GET", attemptPath(id), { signal });
  }
  score(id: string, signal?: AbortSignal) {
    return this.http.json<Score>("GET", `${attemptPath(id)}/score`, { signal });
  }
  async series(id: string, signal?: AbortSignal): Promise<ApiResult<Series>> {
    const result = await this.http.json<unknown>("GET", `${attemptPath(id)}/series`, { signal });
    return result.ok ? understood(checkSeries(result.value)) : result;
  }
  async surface(id: string, signal?: AbortSignal): Promise<ApiResult<Surface>> {
    const bytes = await this.http.bytes(`${attemptPath(id)}/surface`, signal);
    return bytes.ok ? understood(decodeSurface(bytes.value)) : bytes;
  }
  private keepCsrf(result: ApiResult<Session>): ApiResult<Session> {
    if (result.ok) this.http.csrf = result.value.csrf;
    return result;
  }
}

function attemptPath(id: string): string {
  return `/attempts/${segment(id)}`;
}
