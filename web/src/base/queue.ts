// The attempts that somebody goes through one after the other, in the order of the list they came
// from. Kept for one tab of the browser, so that the page of an attempt knows what comes before and
// after it.

export interface Queue {
  readonly back: string; // address of the list
  readonly ids: readonly string[];
}

export interface Place {
  readonly back: string;
  readonly number: number; // from 1
  readonly count: number;
  readonly previous: string | undefined;
  readonly next: string | undefined;
}

type Storage = Pick<globalThis.Storage, "getItem" | "setItem">;

const kKey = "enamel.queue";
const kMaxIds = 2000;

export function keepQueue(queue: Queue, storage: Storage = sessionStorage): void {
  try {
    storage.setItem(kKey, JSON.stringify({ back: queue.back, ids: queue.ids.slice(0, kMaxIds) }));
  } catch {
    // A browser that keeps nothing has no next and previous.
  }
}

// Undefined where the attempt was not come to from a list.
export function placeInQueue(id: string, storage: Storage = sessionStorage): Place | undefined {
  const queue = read(storage);
  const at = queue?.ids.indexOf(id) ?? -1;
  if (queue === undefined || at < 0) return undefined;
  return {
    back: queue.back,
    number: at + 1,
    count: queue.ids.length,
    previous: queue.ids[at - 1],
    next: queue.ids[at + 1],
  };
}

function read(storage: Storage): Queue | undefined {
  try {
    const found: unknown = JSON.parse(storage.getItem(kKey) ?? "null");
    if (typeof found !== "object" || found === null) return undefined;
    const { back, ids } = found as Partial<Queue>;
    if (
      typeof back !== "string" ||
      !back.startsWith("/") ||
      back.startsWith("//") ||
      !Array.isArray(ids) ||
      ids.length > kMaxIds ||
      !ids.every((id) => typeof id === "string")
    )
      return undefined;
    return { back, ids };
  } catch {
    return undefined;
  }
}
