import { useEffect } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Place } from "../../base/queue";

const kAheadMs = 1200;                          // this attempt's own requests come first

// Where in the list this attempt stands, and the ways to the one before and after it. The next one is read ahead.
export function QueueBar({ client, place }: { readonly client: Client; readonly place: Place }) {
  useEffect(() => {
    const { next } = place;
    if (next === undefined) return undefined;
    const timer = setTimeout(() => client.readAhead(next), kAheadMs);
    return () => clearTimeout(timer);
  }, [client, place.next]);
  const way = (id: string | undefined, text: string) => id === undefined ? <span class="hint">{text}</span> : <a href={`/attempts/${id}`}>{text}</a>;
  return (
    <nav class="queue no-print" aria-label="In the list">
      <a href={place.back}>Back to the list</a>
      {way(place.previous, "Previous")}
      <span>{place.number} of {place.count}</span>
      {way(place.next, "Next")}
    </nav>
  );
}
