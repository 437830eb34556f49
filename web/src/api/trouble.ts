import type { ServerHealth } from "./types";

// What stops work, or loses some: the findings of the health page that are bad (features/operations/health_text.ts).
export function troubles({ ingest, clock, standby, disk, backup }: ServerHealth): number {
  return [
    !ingest.takes_recordings,
    clock.problem !== "",
    standby === "missing",
    disk.free_bytes < disk.kept_free_bytes,
    backup !== null && backup.missing > 0,
  ].filter(Boolean).length;
}
