import { useMemo } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Exercise } from "../../api/types";
import { type Json, valueAt } from "../../base/document";
import { say } from "../../base/words";
import { linesOfTarget } from "../../widgets/target_lines";
import { drawnTarget } from "./drawn_target";
import { InitialTooth } from "./initial_tooth";

interface Props {
  readonly client: Client;
  readonly exercise: Exercise;
  readonly target: Json | undefined; // as the form has it now
}

// The target that is being typed, on the tooth that students get.
export function TargetPreview({ client, exercise, target }: Props) {
  const drawn = useMemo(() => drawnTarget(exercise.target, target), [exercise.target, target]);
  const lines = useMemo(() => (drawn === undefined ? undefined : linesOfTarget(drawn)), [drawn]);
  const prepared = target !== undefined && valueAt(target, ["prepared_scene_sha256"]) !== undefined;
  const hint =
    drawn === undefined
      ? say("editor.preview_none")
      : lines === undefined
        ? say("editor.preview_nowhere")
        : say(prepared ? "editor.preview_prepared" : "editor.preview_lines");
  return (
    <InitialTooth client={client} exercise={exercise} title={say("editor.preview")} lines={lines}>
      <p class="hint" aria-live="polite">
        {hint}
      </p>
    </InitialTooth>
  );
}
