import { fail, ok, type Result } from "../base/result";
import { checkSeries } from "./series";
import { decodeSurface, type Surface } from "./surface";
import type {
  AttemptDetail, AttemptPage, AuditEntry, Cohort, ErrorCode, Exercise, ExerciseSummary, Job, Profile, Score, Series,
  Session, Station,
} from "./types";

// Why a request gave nothing. `unreachable`: no answer at all; `malformed`: an answer this page does
// not understand; otherwise the server's own code and sentence.
export interface ApiError {
  readonly code: ErrorCode | "unreachable" | "malformed" | "cancelled";
  readonly status: number;
  readonly message: string;
}

export type ApiResult<T> = Result<T, ApiError>;

export interface AttemptQuery {
  readonly cohort?: string | undefined;
  readonly exercise?: string | undefined;
  readonly person?: string | undefined;
  readonly before?: string | undefined;
  readonly limit?: number | undefined;
}

type Fetch = (path: string, init: RequestInit) => Promise<Response>;

// The server's HTTP API (schemas/api/openapi.yaml). Never throws: every outcome is a Result.
// `sessionLost` is called when a request that needs a session is told there is none.
export class Client {
  private csrf = "";

  constructor(private readonly sessionLost: () => void,
              private readonly send: Fetch = (path, init) => fetch(path, init)) {}

  async signIn(login: string, password: string): Promise<ApiResult<Session>> {
    return this.keepCsrf(await this.json<Session>("POST", "/session", { login, password }, undefined, true));
  }

  // Who is signed in already, if anybody: a missing session is an answer here, not a loss.
  async currentSession(): Promise<ApiResult<Session>> {
    return this.keepCsrf(await this.json<Session>("GET", "/session", undefined, undefined, true));
  }

  async signOut(): Promise<ApiResult<undefined>> {
    const result = await this.empty("DELETE", "/session");
    if (result.ok) this.csrf = "";
    return result;
  }

  exercises(signal?: AbortSignal) {
    return this.json<{ exercises: readonly ExerciseSummary[] }>("GET", "/exercises", undefined, signal);
  }
  exercise(id: string, signal?: AbortSignal) {
    return this.json<Exercise>("GET", `/exercises/${encodeURIComponent(id)}`, undefined, signal);
  }
  cohorts(signal?: AbortSignal) {
    return this.json<{ cohorts: readonly Cohort[] }>("GET", "/cohorts", undefined, signal);
  }
  attempts(query: AttemptQuery, signal?: AbortSignal) {
    const search = new URLSearchParams();
    for (const [name, value] of Object.entries(query)) {
      if (value !== undefined && value !== "") search.set(name, String(value));
    }
    const text = search.toString();
    return this.json<AttemptPage>("GET", `/attempts${text === "" ? "" : `?${text}`}`, undefined, signal);
  }
  attempt(id: string, signal?: AbortSignal) {
    return this.json<AttemptDetail>("GET", attemptPath(id), undefined, signal);
  }
  score(id: string, signal?: AbortSignal) {
    return this.json<Score>("GET", `${attemptPath(id)}/score`, undefined, signal);
  }
  async series(id: string, signal?: AbortSignal): Promise<ApiResult<Series>> {
    const result = await this.json<unknown>("GET", `${attemptPath(id)}/series`, undefined, signal);
    return result.ok ? understood(checkSeries(result.value)) : result;
  }
  async surface(id: string, signal?: AbortSignal): Promise<ApiResult<Surface>> {
    const response = await this.request("GET", `${attemptPath(id)}/surface`, undefined, signal);
    if (!response.ok) return response;
    const bytes = await received(() => response.value.arrayBuffer());
    return bytes.ok ? understood(decodeSurface(bytes.value)) : bytes;
  }
  release(id: string) {
    return this.empty("POST", `${attemptPath(id)}/release`);
  }
  markReference(id: string, dentist: string) {
    return this.json<unknown>("POST", `${attemptPath(id)}/reference`, { dentist });
  }
  profiles(signal?: AbortSignal) {
    return this.json<{ profiles: readonly Profile[] }>("GET", "/profiles", undefined, signal);
  }
  stations(signal?: AbortSignal) {
    return this.json<{ stations: readonly Station[] }>("GET", "/stations", undefined, signal);
  }
  audit(limit: number, signal?: AbortSignal) {
    return this.json<{ audit: readonly AuditEntry[] }>("GET", `/audit?limit=${limit}`, undefined, signal);
  }
  jobs(signal?: AbortSignal) {
    return this.json<{ jobs: readonly Job[] }>("GET", "/jobs", undefined, signal);
  }

  private keepCsrf(result: ApiResult<Session>): ApiResult<Session> {
    if (result.ok) this.csrf = result.value.csrf;
    return result;
  }

  private async json<T>(method: string, path: string, body?: unknown, signal?: AbortSignal,
                        signingIn = false): Promise<ApiResult<T>> {
    const response = await this.request(method, path, body, signal, signingIn);
    if (!response.ok) return response;
    const value = await received(async () => (await response.value.json()) as T);
    if (!value.ok) return value;
    return typeof value.value === "object" && value.value !== null ? value : fail(malformed("JSON that is no object"));
  }

  private async empty(method: string, path: string): Promise<ApiResult<undefined>> {
    const response = await this.request(method, path);
    return response.ok ? ok(undefined) : response;
  }

  private async request(method: string, path: string, body?: unknown, signal?: AbortSignal,
                        signingIn = false): Promise<ApiResult<Response>> {
    const headers: Record<string, string> = {};
    if (body !== undefined) headers["Content-Type"] = "application/json";
    if (method !== "GET" && this.csrf !== "") headers["X-Enamel-Csrf"] = this.csrf;
    const init: RequestInit = { method, headers, credentials: "same-origin", cache: "no-store" };
    if (body !== undefined) init.body = JSON.stringify(body);
    if (signal !== undefined) init.signal = signal;
    try {
      const response = await this.send(`/api/v1${path}`, init);
      if (response.ok) return ok(response);
      if (response.status === 401 && !signingIn) this.sessionLost();
      return fail(await refusal(response));
    } catch {
      return fail(unreachable(signal));
    }
  }
}

function attemptPath(id: string): string {
  return `/attempts/${encodeURIComponent(id)}`;
}

function unreachable(signal: AbortSignal | undefined): ApiError {
  if (signal?.aborted === true) return { code: "cancelled", status: 0, message: "The request was cancelled." };
  return { code: "unreachable", status: 0,
           message: "The server does not answer. Check that it runs and that this computer is connected, then try again." };
}

function malformed(found: string): ApiError {
  return { code: "malformed", status: 0,
           message: `The server's answer was not understood: ${found}. Load the page again; if it stays, tell the administrator.` };
}

function understood<T>(result: Result<T, string>): ApiResult<T> {
  return result.ok ? result : fail(malformed(result.error));
}

async function received<T>(read: () => Promise<T>): Promise<ApiResult<T>> {
  try {
    return ok(await read());
  } catch {
    return fail(malformed("the body was cut off or is no JSON"));
  }
}

async function refusal(response: Response): Promise<ApiError> {
  const kFallback = `The server refused the request with status ${response.status}.`;
  try {
    const { error } = (await response.json()) as { error?: { code?: ErrorCode; message?: string } };
    return { code: error?.code ?? "internal", status: response.status, message: error?.message ?? kFallback };
  } catch {
    return { code: "internal", status: response.status, message: kFallback };
  }
}
