import { type Http, segment } from "./http";
import type { Marking, MarkingSummary } from "./types";

export type Rating = 1 | 2 | 3 | 4 | 5; // clear fail, borderline, clear pass, good, excellent

export interface CriterionMark {
  readonly points: number;
  readonly comment: string;
}

// Several people mark an assignment's attempts without seeing names and computed scores (schemas/marks.md, "Blind
// marking").
export class MarkingApi {
  constructor(private readonly http: Http) {}

  // Newest first.
  of(assignment: string, signal?: AbortSignal) {
    return this.http.all<MarkingSummary>(`/assignments/${segment(assignment)}/markings`, "markings", {}, signal);
  }
  begin(assignment: string, markers: readonly string[]) {
    return this.http.json<MarkingSummary>("POST", `/assignments/${segment(assignment)}/markings`, {
      body: { marker_ids: markers },
    });
  }
  get(id: string, signal?: AbortSignal) {
    return this.http.json<Marking>("GET", `/markings/${segment(id)}`, { signal });
  }
  // Who marks from now on. Marks of those who are left out enter no result.
  setMarkers(id: string, markers: readonly string[]) {
    return this.http.json<MarkingSummary>("PUT", `/markings/${segment(id)}/markers`, { body: { marker_ids: markers } });
  }
  // Marks that were given stay.
  giveUp(id: string) {
    return this.http.empty("DELETE", `/markings/${segment(id)}`);
  }
  // Once for each work.
  mark(work: string, rating: Rating, criteria: Readonly<Record<string, CriterionMark>>) {
    return this.http.empty("POST", `/marking-works/${segment(work)}/marks`, { body: { rating, criteria } });
  }
  // How the work was cut (tooth/timeline.ts). Unavailable: it is still being made.
  timeline(work: string, signal?: AbortSignal) {
    return this.http.bytes(`/marking-works/${segment(work)}/timeline`, signal);
  }
}
