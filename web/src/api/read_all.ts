import { ok } from "../base/result";
import type { ApiResult, Page } from "./http";

const kMostPages = 200;

// The pages of a list, one after the other, up to kMostPages of them (40 000 rows of 200): what comes after is left out.
// Ends early with an error of any of them.
export async function readAll<T>(ask: (cursor: string | undefined) => Promise<ApiResult<Page<T>>>): Promise<ApiResult<readonly T[]>> {
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
