import type { paths } from "./types";

// What schemas/api/openapi.yaml says of each operation, for the compiler: `Http` takes and gives nothing else.

type Paths = { [P in keyof paths as P extends `/api/v1${infer Rest}` ? Rest : never]: paths[P] };

export type Method = "GET" | "POST" | "PUT" | "PATCH" | "DELETE";

export type PathOf<M extends Method> = {
  [P in keyof Paths]: Paths[P] extends Record<Lowercase<M>, object> ? P : never;
}[keyof Paths];

type Operation<M extends Method, P extends PathOf<M>> = Paths[P] extends Record<Lowercase<M>, infer O> ? O : never;

type In<O, Where extends "path" | "query" | "header"> = O extends {
  readonly parameters: { readonly [W in Where]?: infer T };
}
  ? [NonNullable<T>] extends [never]
    ? unknown
    : NonNullable<T>
  : unknown;

// A text is sent as it is, and so is what has a type.
type BodyOf<O> = O extends { readonly requestBody: { readonly content: infer C } }
  ?
      | (C extends { readonly "application/json": infer J }
          ? { readonly body: J | string; readonly type?: undefined }
          : never)
      | { readonly body: string | Blob | ArrayBuffer; readonly type: keyof C & string }
  : unknown;
type TagOf<O> =
  In<O, "header"> extends { readonly "If-Match": string }
    ? { readonly tag: string | number }
    : "If-Match" extends keyof In<O, "header">
      ? { readonly tag?: string }
      : unknown;

export interface Manner {
  readonly signal?: AbortSignal | undefined;
  readonly kept?: boolean; // may come from the browser's cache, as the server says
  readonly signingIn?: boolean; // a missing session is an answer here, not a loss
}

// All that a request takes: the places of its path and query by their names, and how it is sent.
export type Asked<M extends Method, P extends PathOf<M>> = AskedOf<Operation<M, P>>;
type AskedOf<O> = In<O, "path"> & In<O, "query"> & BodyOf<O> & TagOf<O> & Manner;
// Left out where nothing has to be said.
export type Rest<A> = Manner extends A ? [asked?: A] : [asked: A];

type Json<R> = R extends { readonly content: { readonly "application/json": infer T } } ? T : undefined;
export type Answer<M extends Method, P extends PathOf<M>> =
  Operation<M, P> extends { readonly responses: infer R }
    ? { [S in keyof R & (200 | 201 | 202 | 204)]: Json<R[S]> }[keyof R & (200 | 201 | 202 | 204)]
    : never;

// Of the one list in an answer.
export type Item<P extends PathOf<"GET">> = ItemOf<Answer<"GET", P>>;
type ItemOf<A> = { [K in keyof A]: A[K] extends ReadonlyArray<infer T> ? T : never }[keyof A];
