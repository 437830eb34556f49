import type { ApiResult } from "../../api/http";

// The same change of several things, one after the other, so that each has its own answer.

export interface Outcome<T> {
  readonly done: readonly T[];
  readonly failed: readonly { readonly item: T; readonly message: string }[];
}

export async function forEach<T>(
  items: readonly T[],
  change: (item: T) => Promise<ApiResult<unknown>>,
  told: (count: number) => void = () => {},
): Promise<Outcome<T>> {
  const done: T[] = [];
  const failed: { item: T; message: string }[] = [];
  for (const item of items) {
    const result = await change(item);
    if (result.ok) done.push(item);
    else failed.push({ item, message: result.error.message });
    told(done.length + failed.length);
  }
  return { done, failed };
}
