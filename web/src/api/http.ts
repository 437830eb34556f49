import { fail, ok, type Result } from "../base/result";
import { sentence } from "../base/format";
import { say, sayIf } from "../base/words";
import { spokenLanguage } from "../base/language";
import { Ahead } from "./ahead";
import type { Answer, Asked, Item, Method, PathOf, Rest } from "./contract";
import { apiAddress, type Fetch, fill, type RequestOptions, requestInit, sendByFetch } from "./request_init";
import type { ErrorCode } from "./types";

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

const kMaxRows = 200; // that the server gives in a page
const kMaxPages = 200; // of a list that is read to its end

// How requests of the HTTP API (schemas/api/openapi.yaml) travel. Never throws: every outcome is a
// Result. `sessionLost` is called when a request needs a session and the server reports none.
export class Http {
  csrf = ""; // the session's; empty while signed out
  // Asks the person for the password again, where the server wants that for a change; true when it
  // was given, and the change is then sent once more.
  confirm: () => Promise<boolean> = async () => false;

  constructor(
    private readonly sessionLost: () => void,
    private readonly fetch: Fetch = sendByFetch,
    readonly ahead = new Ahead(),
  ) {}

  readonly get = this.sends("GET");
  readonly post = this.sends("POST");
  readonly put = this.sends("PUT");
  readonly patch = this.sends("PATCH");
  readonly delete = this.sends("DELETE");

  // What an operation of the contract answers; undefined where it says nothing.
  private sends<M extends Method>(method: M) {
    return async <P extends PathOf<M>>(path: P, ...asked: Rest<Asked<M, P>>): Promise<ApiResult<Answer<M, P>>> => {
      const tagged = await this.tagged(method, path, ...asked);
      return tagged.ok ? ok(tagged.value.value) : tagged;
    };
  }

  async tagged<M extends Method, P extends PathOf<M>>(
    method: M,
    path: P,
    ...[asked]: Rest<Asked<M, P>>
  ): Promise<ApiResult<Tagged<Answer<M, P>>>> {
    const response = await this.request(method, ...sent(path, asked));
    if (!response.ok) return response;
    if (response.value.status === 204) return ok({ value: undefined as Answer<M, P>, tag: "" });
    const value = await received(async () => (await response.value.json()) as Answer<M, P>);
    if (!value.ok) return value;
    if (typeof value.value !== "object" || value.value === null) return fail(malformed("JSON, but no object"));
    return ok({ value: value.value, tag: response.value.headers.get("ETag") ?? "" });
  }

  // The list in an answer.
  async page<P extends PathOf<"GET">>(path: P, ...asked: Rest<Asked<"GET", P>>): Promise<ApiResult<Page<Item<P>>>> {
    const result = await this.get(path, ...asked);
    if (!result.ok) return result;
    const answer = result.value as Readonly<Record<string, unknown>>;
    const items = Object.values(answer).find(Array.isArray);
    if (items === undefined) return fail(malformed("an answer without a list"));
    return ok({ items, next: typeof answer["next"] === "string" ? answer["next"] : null });
  }
  // All of a list, page after page, up to kMaxPages of them (40 000 rows): what comes after is left out. Ends early with
  // an error of any of them.
  async all<P extends PathOf<"GET">>(
    path: P,
    ...[asked]: Rest<Asked<"GET", P>>
  ): Promise<ApiResult<readonly Item<P>[]>> {
    const items: Item<P>[] = [];
    let cursor: string | undefined;
    for (let page = 0; page < kMaxPages; ++page) {
      const part = [{ ...asked, limit: kMaxRows, cursor }] as unknown as Rest<Asked<"GET", P>>;
      const result = await this.page(path, ...part);
      if (!result.ok) return result;
      items.push(...result.value.items);
      if (result.value.next === null) break;
      cursor = result.value.next;
    }
    return ok(items);
  }

  async bytes<P extends PathOf<"GET">>(path: P, asked: Asked<"GET", P>): Promise<ApiResult<ArrayBuffer>> {
    const response = await this.request("GET", ...sent(path, asked));
    return response.ok ? received(() => response.value.arrayBuffer()) : response;
  }
  // Bytes from `from` to before `to`, as they come; fewer where there are no more. The browser keeps them, and asks
  // each time whether they are still the same.
  async stream<P extends PathOf<"GET">>(
    path: P,
    [from, to]: readonly [number, number],
    asked: Asked<"GET", P>,
  ): Promise<ApiResult<ReadableStream<Uint8Array<ArrayBuffer>>>> {
    const [address, options] = sent(path, asked);
    const response = await this.request("GET", address, { ...options, range: [from, to], kept: true });
    if (!response.ok) return response;
    if (response.value.status !== 206 && from > 0) return fail(malformed("all of it where a part was asked for"));
    const { body } = response.value;
    return body === null ? fail(malformed("an empty body")) : ok(body);
  }

  private async request(
    method: Method,
    path: string,
    options: RequestOptions,
    confirmed = false,
  ): Promise<ApiResult<Response>> {
    try {
      const send = () => this.fetch(apiAddress(path), requestInit(method, options, this.csrf));
      const early = method === "GET" ? this.ahead.take(path, options) : undefined;
      let response = await (early ?? send());
      // What was not there yet when it was asked for ahead, as the score of an attempt in the queue, may be there now.
      if (early !== undefined && (response.status === 404 || response.status === 409)) response = await send();
      if (response.ok) return ok(response);
      if (response.status === 401 && options.signingIn !== true) this.sessionLost();
      const error = await refusal(response, method);
      if (error.code !== "confirm_password" || confirmed || !(await this.confirm())) return fail(error);
      return await this.request(method, path, options, true);
    } catch {
      return fail(unreachable(options.signal));
    }
  }
}

// What is said about a thing is said about it as it was seen.
export const seen = ({ id, revision }: { readonly id: string; readonly revision: number }) => ({ id, tag: revision });

export function understood<T>(result: Result<T, string>): ApiResult<T> {
  return result.ok ? result : fail(malformed(result.error));
}

// Why it failed (as widgets/dialog.tsx asks for it), or goes on.
export async function failed<T>(asked: Promise<ApiResult<T>>, then: (value: T) => void): Promise<string | undefined> {
  const result = await asked;
  if (!result.ok) return result.error.message;
  then(result.value);
  return undefined;
}

// The answer where a refusal brings it along: what is wrong with what was sent is in `member`.
export async function reported<T>(asked: Promise<ApiResult<T>>, member: string & keyof T): Promise<ApiResult<T>> {
  const result = await asked;
  const answer = result.ok ? undefined : result.error.answer;
  return Array.isArray(answer?.[member]) ? ok(answer as T) : result;
}

// Of what the browser itself loads, as a file that is saved.
export function addressOf<P extends PathOf<"GET">>(path: P, asked: Asked<"GET", P>): string {
  return apiAddress(fill(path, asked));
}

function sent(path: string, asked: unknown): [string, RequestOptions] {
  const { body, type, tag, signal, kept, signingIn, ...given } = { ...(asked as RequestOptions) };
  return [fill(path, given), { body, type, tag, signal, kept, signingIn }];
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
