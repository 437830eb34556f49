// How a request of the HTTP API (schemas/api/openapi.yaml) is sent.

export interface RequestOptions {
  readonly body?: unknown; // sent as JSON; with `type` as it is
  readonly type?: string | undefined;
  readonly tag?: string | undefined; // If-Match
  readonly signal?: AbortSignal | undefined;
  readonly range?: readonly [number, number]; // bytes: from, to before
  readonly kept?: boolean; // may come from the browser's cache, as the server says
  readonly signingIn?: boolean; // a missing session is an answer here, not a loss
}

export type Method = "GET" | "POST" | "PUT" | "PATCH" | "DELETE";
export type Fetch = (path: string, init: RequestInit) => Promise<Response>;

export const apiAddress = (path: string) => `/api/v1${path}`;
export const sendByFetch: Fetch = (path, init) => fetch(path, init);

// `csrf`: the session's; empty while signed out.
export function requestInit(
  method: Method,
  { body, type, tag, signal, range, kept }: RequestOptions,
  csrf = "",
): RequestInit {
  const headers: Record<string, string> = {};
  if (body !== undefined) headers["Content-Type"] = type ?? "application/json";
  if (method !== "GET" && csrf !== "") headers["X-Enamel-Csrf"] = csrf;
  if (tag !== undefined) headers["If-Match"] = tag;
  if (range !== undefined) headers["Range"] = `bytes=${range[0]}-${range[1] - 1}`;
  const init: RequestInit = {
    method,
    headers,
    credentials: "same-origin",
    cache: kept === true ? "default" : "no-store",
  };
  if (body !== undefined) init.body = type === undefined ? JSON.stringify(body) : (body as BodyInit);
  if (signal !== undefined) init.signal = signal;
  return init;
}
