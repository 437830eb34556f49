import { useEffect } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Place } from "../../base/queue";
import { say } from "../../base/words";

const kAheadMs = 1200; // this attempt's own requests come first

// Where in the list this attempt stands, and the ways to the one before and after it. The next one
// is read ahead.
export function QueueBar({ client, place }: { readonly client: Client; readonly place: Place }) {
  const { next } = place;
  useEffect(() => {
    if (next === undefined) return undefined;
    const timer = setTimeout(() => client.readAhead(next), kAheadMs);
    return () => clearTimeout(timer);
  }, [client, next]);
  const way = (id: string | undefined, text: string) =>
    id === undefined ? <span class="hint">{text}</span> : <a href={`/attempts/${id}`}>{text}</a>;
  return (
    <nav class="queue no-print" aria-label={say("queue.title")}>
      <a href={place.back}>{say("queue.back")}</a>
      {way(place.previous, say("queue.previous"))}
      <span>{say("count.of", { part: String(place.number), whole: String(place.count) })}</span>
      {way(next, say("queue.next"))}
    </nav>
  );
}
