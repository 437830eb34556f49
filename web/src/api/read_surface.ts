import { fail } from "../base/result";
import { say } from "../base/words";
import { type ApiResult, understood } from "./http";
import type { Surface } from "./surface";

// A tooth of what the server sent. What reads it is fetched with the first one: most screens show
// none.
export async function readSurface(bytes: ApiResult<ArrayBuffer>): Promise<ApiResult<Surface>> {
  if (!bytes.ok) return bytes;
  const reader = await import("./surface").catch(() => undefined);
  return reader === undefined
    ? fail({ code: "unreachable", status: 0, field: "", message: say("error.unreachable") })
    : understood(reader.decodeSurface(bytes.value));
}
