import { fail, ok, type Result } from "../base/result";
import { sentence } from "../base/format";
import { say, sayIf } from "../base/words";
import { spokenLanguage } from "../base/language";
import { Ahead } from "./ahead";
import { apiAddress, type Fetch, type Method, type RequestOptions, requestInit, sendByFetch } from "./request_init";
import type { ErrorCode } from "./types";

export { segment } from "./ahead";
export type { Fetch, Method, RequestOptions } from "./request_init";

// Why a request gave nothing. `unreachable`: no answer at all; `malformed`: an answer this page
// does not understand; otherwise the server's own code and sentence.
export interface ApiError {
  readonly code: ErrorCode | "unreachable" | "malformed" | "cancelled";
  readonly status: number;
  readonly message: string;
  readonly field: string; // what of the request is at fault; empty when nothing is named
  readonly current?: Tagged<unknown>; // with 412: the thing as somebody else saved it meanwhile
  readonly answer?: Readonly<Record<string, unknown>>; // all that the server said
}

export type ApiResult<T> = Result<T, ApiError>;

// Something that can be edited, with the tag (HTTP ETag) that an edit of it has to repeat.
export interface Tagged<T> {
  readonly value: T;
  readonly tag: string;
}

// Part of a list.
export interface Page<T> {
  readonly items: readonly T[];
  readonly next: string | null; // cursor of the page after this one
}

export type Query = Readonly<Record<string, string | number | boolean | undefined>>;

const kMostRows = 200; // that the server gives in a page
const kMostPages = 200;

// The pages of a list, one after the other, up to kMostPages of them (40 000 rows of 200): what
// comes after is left out. Ends early with an error of any of them.
export async function readAll<T>(
  ask: (cursor: string | undefined) => Promise<ApiResult<Page<T>>>,
): Promise<ApiResult<readonly T[]>> {
  const items: T[] = [];
  let cursor: string | undefined;
  for (let page = 0; page < kMostPages; ++page) {
    const result = await ask(cursor);
    if (!result.ok) return result;
    items.push(...result.value.items);
    if (result.value.next === null) break;
    cursor = result.value.next;
  }
  return ok(items);
}

// How requests of the HTTP API (schemas/api/openapi.yaml) travel. Never throws: every outcome is a
// Result. `sessionLost` is called when a request needs a session and the server reports none.
export class Http {
  csrf = ""; // the session's; empty while signed out
  // Asks the person for the password again, where the server wants that for a change; true when it
  // was given, and the change is then sent once more.
  confirmPassword: () => Promise<boolean> = async () => false;

  constructor(
    private readonly sessionLost: () => void,
    private readonly send: Fetch = sendByFetch,
    readonly ahead = new Ahead(),
  ) {}

  async json<T>(method: Method, path: string, options: RequestOptions = {}): Promise<ApiResult<T>> {
    const tagged = await this.tagged<T>(method, path, options);
    return tagged.ok ? ok(tagged.value.value) : tagged;
  }

  async tagged<T>(method: Method, path: string, options: RequestOptions = {}): Promise<ApiResult<Tagged<T>>> {
    const response = await this.request(method, path, options);
    if (!response.ok) return response;
    const value = await received(async () => (await response.value.json()) as T);
    if (!value.ok) return value;
    if (typeof value.value !== "object" || value.value === null) return fail(malformed("JSON, but no object"));
    return ok({ value: value.value, tag: response.value.headers.get("ETag") ?? "" });
  }

  // `name`: the member of the answer that holds the list.
  async page<T>(path: string, name: string, query: Query, signal?: AbortSignal): Promise<ApiResult<Page<T>>> {
    const result = await this.json<Readonly<Record<string, unknown>>>("GET", path + queryText(query), { signal });
    if (!result.ok) return result;
    const { [name]: items, next } = result.value;
    if (!Array.isArray(items)) return fail(malformed(`a list without ${name}`));
    return ok({ items: items as T[], next: typeof next === "string" ? next : null });
  }

  // All of a list, page after page.
  all<T>(path: string, name: string, query: Query, signal?: AbortSignal): Promise<ApiResult<readonly T[]>> {
    return readAll((cursor) => this.page<T>(path, name, { ...query, limit: kMostRows, cursor }, signal));
  }

  async bytes(path: string, signal?: AbortSignal): Promise<ApiResult<ArrayBuffer>> {
    return this.read(path, { signal });
  }
  // Bytes from `from` to before `to`, as they come; fewer where there are no more. The browser keeps them, and asks
  // each time whether they are still the same.
  async stream(
    path: string,
    from: number,
    to: number,
    signal?: AbortSignal,
  ): Promise<ApiResult<ReadableStream<Uint8Array<ArrayBuffer>>>> {
    const response = await this.request("GET", path, { signal, range: [from, to], kept: true });
    if (!response.ok) return response;
    if (response.value.status !== 206 && from > 0) return fail(malformed("all of it where a part was asked for"));
    const { body } = response.value;
    return body === null ? fail(malformed("an empty body")) : ok(body);
  }
  // From the browser's own cache where the server says that it may be kept.
  async kept(path: string, signal?: AbortSignal): Promise<ApiResult<ArrayBuffer>> {
    return this.read(path, { signal, kept: true });
  }

  private async read(path: string, options: RequestOptions): Promise<ApiResult<ArrayBuffer>> {
    const response = await this.request("GET", path, options);
    return response.ok ? received(() => response.value.arrayBuffer()) : response;
  }

  async empty(method: Method, path: string, options: RequestOptions = {}): Promise<ApiResult<undefined>> {
    const response = await this.request(method, path, options);
    return response.ok ? ok(undefined) : response;
  }

  private async request(
    method: Method,
    path: string,
    options: RequestOptions,
    confirmed = false,
  ): Promise<ApiResult<Response>> {
    try {
      const send = () => this.send(apiAddress(path), requestInit(method, options, this.csrf));
      const early = method === "GET" ? this.ahead.take(path, options) : undefined;
      let response = await (early ?? send());
      // What was not there yet when it was asked for ahead, as the score of an attempt in the queue, may be there now.
      if (early !== undefined && (response.status === 404 || response.status === 409)) response = await send();
      if (response.ok) return ok(response);
      if (response.status === 401 && options.signingIn !== true) this.sessionLost();
      const error = await refusal(response, method);
      if (error.code !== "confirm_password" || confirmed || !(await this.confirmPassword())) return fail(error);
      return await this.request(method, path, options, true);
    } catch {
      return fail(unreachable(options.signal));
    }
  }
}

// "?a=1&b=2" of what is given; empty when nothing is.
export function queryText(query: Query): string {
  const search = new URLSearchParams();
  for (const [name, value] of Object.entries(query)) {
    if (value !== undefined && value !== "") search.set(name, String(value));
  }
  const text = search.toString();
  return text === "" ? "" : `?${text}`;
}

// The ETag of a thing that came in a list, from its revision.
export function tagOf(revision: number): string {
  return `"${revision}"`;
}

export function understood<T>(result: Result<T, string>): ApiResult<T> {
  return result.ok ? result : fail(malformed(result.error));
}

function unreachable(signal: AbortSignal | undefined): ApiError {
  if (signal?.aborted === true) return { code: "cancelled", status: 0, message: say("error.cancelled"), field: "" };
  return { code: "unreachable", status: 0, field: "", message: say("error.unreachable") };
}

function malformed(found: string): ApiError {
  return { code: "malformed", status: 0, field: "", message: say("error.malformed", { found }) };
}

async function received<T>(read: () => Promise<T>): Promise<ApiResult<T>> {
  try {
    return ok(await read());
  } catch {
    return fail(malformed("the body was cut off or is no JSON"));
  }
}

// Where something is in a state that everybody meets, the field names the state and the page has words for it. Some
// refusals are known by their code and the member that they refuse.
// Otherwise: the server's messages are English, and other languages show a sentence for the code instead, followed by
// the message where the code alone says too little.
function errorText(code: string | undefined, field: string | undefined, said: string): string {
  const state = sayIf(`error_state.${field ?? ""}`) ?? sayIf(`error_code.${code ?? ""}_${field ?? ""}`);
  if (state !== undefined) return state;
  return spokenLanguage() === "en" ? sentence(said) : (sayIf(`error_code.${code ?? ""}`, { said }) ?? said);
}

// Something was read that is not there, or by what is no id at all: the page's address is wrong.
function isAddress({ code, field }: { readonly code?: string; readonly field?: string }, method: Method): boolean {
  return method === "GET" && (code === "not_found" || (code === "invalid_input" && field === "id"));
}

async function refusal(response: Response, method: Method): Promise<ApiError> {
  const kFallback = say("error.status", { status: String(response.status) });
  try {
    const answer = (await response.json()) as {
      error?: { code?: ErrorCode; message?: string; field?: string };
      current?: unknown;
    };
    const { error, current } = answer;
    return {
      code: error?.code ?? "internal",
      status: response.status,
      message:
        error === undefined
          ? kFallback
          : isAddress(error, method)
            ? say("error.no_such")
            : errorText(error.code, error.field, error.message ?? kFallback),
      field: error?.field ?? "",
      answer,
      ...(current === undefined ? {} : { current: { value: current, tag: response.headers.get("ETag") ?? "" } }),
    };
  } catch {
    return { code: "internal", status: response.status, message: kFallback, field: "" };
  }
}
