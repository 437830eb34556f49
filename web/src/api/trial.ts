import type { Client } from "./client";
import { type ApiResult, segment } from "./http";
import type { ExerciseTrial } from "./types";

// Tries an exercise document and asks until it is done or failed; `onChange` hears of each step. If
// the person leaves before, the server ends it.
export async function tryExercise(
  { http }: Client,
  text: string,
  onChange: (now: ExerciseTrial) => void,
  pollMs: number,
  signal: AbortSignal,
): Promise<ApiResult<ExerciseTrial>> {
  let now = await http.json<ExerciseTrial>("POST", "/exercise-trials", { body: text, type: "application/json" });
  while (now.ok && (now.value.state === "waiting" || now.value.state === "working")) {
    const path = `/exercise-trials/${segment(now.value.id)}`;
    if (!signal.aborted) onChange(now.value);
    await new Promise((done) => setTimeout(done, pollMs));
    if (signal.aborted) {
      await http.empty("DELETE", path);
      return now;
    }
    now = await http.json<ExerciseTrial>("GET", path);
  }
  return now;
}
