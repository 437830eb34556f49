import type { Manner, Method } from "./contract";

// How a request of the HTTP API (schemas/api/openapi.yaml) is sent.

export interface RequestOptions extends Manner {
  readonly body?: unknown; // sent as JSON; a text, and what has a type, as it is
  readonly type?: string | undefined;
  readonly tag?: string | number | undefined; // If-Match: an ETag, or the revision that is in it
  readonly range?: readonly [number, number]; // bytes: from, to before
}

export type Query = Readonly<Record<string, string | number | boolean | undefined>>;

export type Fetch = (path: string, init: RequestInit) => Promise<Response>;

export const apiAddress = (path: string) => `/api/v1${path}`;
export const sendByFetch: Fetch = (path, init) => fetch(path, init);

// "?a=1&b=2" of what is given; empty when nothing is.
export function queryText(query: Query): string {
  const search = new URLSearchParams();
  for (const [name, value] of Object.entries(query)) {
    if (value !== undefined && value !== "") search.set(name, String(value));
  }
  const text = search.toString();
  return text === "" ? "" : `?${text}`;
}

// A path of the contract with what is given in its places, and the rest of it as query.
export function fill(path: string, given: object): string {
  const query = { ...given } as Record<string, string>;
  const filled = path.replaceAll(/\{(\w+)\}/g, (_, name: string) => {
    const { [name]: value = "" } = query;
    delete query[name];
    return encodeURIComponent(value);
  });
  return filled + queryText(query);
}

// `csrf`: the session's; empty while signed out.
export function requestInit(
  method: Method,
  { body, type, tag, signal, range, kept }: RequestOptions,
  csrf = "",
): RequestInit {
  const headers: Record<string, string> = {};
  if (body !== undefined) headers["Content-Type"] = type ?? "application/json";
  if (method !== "GET" && csrf !== "") headers["X-Enamel-Csrf"] = csrf;
  if (tag !== undefined) headers["If-Match"] = typeof tag === "number" ? `"${tag}"` : tag;
  if (range !== undefined) headers["Range"] = `bytes=${range[0]}-${range[1] - 1}`;
  const init: RequestInit = {
    method,
    headers,
    credentials: "same-origin",
    cache: kept === true ? "default" : "no-store",
  };
  if (body !== undefined)
    init.body = type === undefined && typeof body !== "string" ? JSON.stringify(body) : (body as BodyInit);
  if (signal !== undefined) init.signal = signal;
  return init;
}
