import { fail, ok, type Result } from "../base/result";
import { addressOf } from "./http";
import type { LiveEvent } from "./types";

// One moment of an attempt in progress.
export interface LiveRow {
  readonly tick: number;
  readonly anchorMm: readonly [number, number, number]; // from the device's origin, along the scene's axes
  readonly forceN: readonly [number, number, number]; // on the operator
  readonly flags: number;
}

export interface LiveListener {
  readonly onRows: (rows: readonly LiveRow[]) => void;
  readonly onEnd: () => void; // the attempt was sealed; nothing more comes
  readonly onProblem: (message: string) => void; // nothing more comes unless rows follow: the browser tries again by itself
}

const kColumns = 8;
const kMaxRows = 10_000;

// The error says what was found.
export function checkLiveEvent(text: string): Result<readonly LiveRow[], string> {
  let event: Partial<LiveEvent>;
  try {
    event = JSON.parse(text) as Partial<LiveEvent>;
  } catch {
    return fail("the event is no JSON");
  }
  if (typeof event !== "object" || event === null || !Array.isArray(event.rows)) return fail("the event has no rows");
  if (event.rows.length > kMaxRows)
    return fail(`the event has ${event.rows.length} rows, at most ${kMaxRows} are expected`);
  const rows: LiveRow[] = [];
  for (const row of event.rows as ReadonlyArray<unknown>) {
    if (!Array.isArray(row) || row.length !== kColumns || !row.every((value) => Number.isFinite(value)))
      return fail(`row ${rows.length} is not ${kColumns} numbers`);
    const [tick, x, y, z, fx, fy, fz, flags] = row as [number, number, number, number, number, number, number, number];
    if (tick <= (rows.at(-1)?.tick ?? -1)) return fail(`ticks do not grow at row ${rows.length}`);
    rows.push({ tick, anchorMm: [x / 1000, y / 1000, z / 1000], forceN: [fx / 1000, fy / 1000, fz / 1000], flags });
  }
  return ok(rows);
}

export function forceSize({ forceN: [x, y, z] }: LiveRow): number {
  return Math.hypot(x, y, z);
}

type OpenStream = (address: string) => Pick<EventSource, "addEventListener" | "close" | "readyState">;

const kClosed = 2; // EventSource.CLOSED

// Follows an attempt until the returned function is called or the attempt ends. The browser comes
// back by itself when the server ends a stream for its age.
export function watchAttempt(
  id: string,
  listener: LiveListener,
  open: OpenStream = (address) => new EventSource(address),
): () => void {
  const source = open(addressOf("/attempts/{id}/live", { id }));
  source.addEventListener("ticks", (event) => {
    const rows = checkLiveEvent((event as MessageEvent<string>).data);
    if (rows.ok) listener.onRows(rows.value);
    else listener.onProblem(`The live picture was not understood: ${rows.error}.`);
  });
  source.addEventListener("end", () => {
    source.close();
    listener.onEnd();
  });
  source.addEventListener("error", () => {
    listener.onProblem(
      source.readyState === kClosed
        ? "The attempt is not being made now, or may not be watched."
        : "The connection was lost; trying again.",
    );
  });
  return () => source.close();
}
