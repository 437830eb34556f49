import { checkSeries, checkTicks } from "./series";
import { type ApiResult, Http, understood } from "./http";
import type { Series, Session, Ticks } from "./types";

interface NextOne {
  readonly id: string;
  series: Promise<ApiResult<Series>> | undefined;
}

// The server's HTTP API (schemas/api/openapi.yaml). Never throws: every outcome is a Result. Beside the operations
// themselves: the session, and what is read of an attempt.
export class Client extends Http {
  private next: NextOne | undefined; // of one attempt at most

  async signIn(login: string, password: string): Promise<ApiResult<Session>> {
    this.ahead.forget();
    return this.keepCsrf(await this.post("/session", { body: { login, password }, signingIn: true }));
  }

  // Who is signed in already, if anybody: a missing session is an answer here, not a loss.
  async currentSession(): Promise<ApiResult<Session>> {
    return this.keepCsrf(await this.get("/session", { signingIn: true }));
  }

  async signOut(): Promise<ApiResult<undefined>> {
    const result = await this.delete("/session");
    if (result.ok) this.csrf = "";
    return result;
  }

  // Ends every session of this person and begins another, with a csrf value of its own.
  async changePassword(old: string, fresh: string): Promise<ApiResult<Session>> {
    return this.keepCsrf(await this.post("/session/password", { body: { old_password: old, new_password: fresh } }));
  }

  // In the server's words: wordedScore (worded.ts) has those of the page.
  score(id: string, signal?: AbortSignal) {
    return this.get("/attempts/{id}/score", { id, signal, kept: true });
  }
  async series(id: string, signal?: AbortSignal): Promise<ApiResult<Series>> {
    const ahead = await this.takeAhead(id);
    return ahead?.ok === true ? ahead : this.askSeries(id, signal);
  }
  // Of the recording itself: at most 4000 ticks of time.
  async ticks(id: string, from: number, to: number, signal?: AbortSignal): Promise<ApiResult<Ticks>> {
    const result = await this.get("/attempts/{id}/ticks", { id, from, to, signal });
    return result.ok ? understood(checkTicks(result.value)) : result;
  }
  // Reads the series of an attempt that will probably be opened next. It is given out once; a
  // failure is asked again.
  readAhead(id: string): void {
    if (this.next?.id !== id) this.next = { id, series: this.askSeries(id) };
  }
  private takeAhead(id: string): NextOne["series"] {
    if (this.next?.id !== id) return undefined;
    const found = this.next.series;
    this.next.series = undefined;
    return found;
  }
  private async askSeries(id: string, signal?: AbortSignal): Promise<ApiResult<Series>> {
    const result = await this.get("/attempts/{id}/series", { id, signal, kept: true });
    return result.ok ? understood(checkSeries(result.value)) : result;
  }
  private keepCsrf(result: ApiResult<Session>): ApiResult<Session> {
    if (result.ok) this.csrf = result.value.csrf;
    return result;
  }
}
