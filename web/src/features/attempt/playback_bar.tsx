import type { PlaybackControl } from "./use_playback";

// Play, pause, speed and the moment of the tooth's picture.
export function PlaybackBar({ control }: { readonly control: PlaybackControl }) {
  const { playback, playing, speed, speeds, rate } = control;
  const { state } = playback;
  if (state.state === "waiting") return <p class="hint" role="status">{waitingText}</p>;
  if (state.state === "failed") return <p class="hint" role="status">The attempt cannot be played back: {state.error.message}</p>;
  if (state.state === "loading" || !playback.whole) return <p class="hint" role="status">Loading the playback…</p>;
  if (playback.frames === 0) return null;
  // Always one decimal, so that nothing beside it moves.
  const seconds = (frames: number) => `${(frames / rate).toFixed(1)} s`;
  return (
    <div class="playback no-print" role="group" aria-label="Playback" onKeyDown={(event) => playbackKey(event, control)}>
      <button type="button" class="button small" aria-label="One frame back" onClick={() => control.step(-1)}>‹</button>
      <button type="button" class="button small playback-play" onClick={control.toggle}>{playing ? "Pause" : "Play"}</button>
      <button type="button" class="button small" aria-label="One frame on" onClick={() => control.step(1)}>›</button>
      <input type="range" min={0} max={playback.frames} step={1} value={playback.position} aria-label="Playback position"
             aria-valuetext={`${seconds(playback.position)} of ${seconds(playback.frames)}`} onInput={(event) => control.show(Number(event.currentTarget.value))} />
      <span class="playback-time">{seconds(playback.position)}</span>
      <label class="playback-speed">Speed
        <select value={speed} onChange={(event) => control.setSpeed(Number(event.currentTarget.value))}>
          {speeds.map((value) => <option key={value} value={value}>{`${value}×`}</option>)}
        </select>
      </label>
      <p class="hint">Here and in the picture: Space or K plays and pauses, J and L jump 5 s; the arrow keys on the slider move by a frame</p>
    </div>
  );
}

const waitingText = "The playback of this attempt is being made. It shows here by itself in a few minutes.";

// Returns whether the key was one of the playback's. Space on a button or a list is theirs.
export function playbackKey(event: KeyboardEvent, control: PlaybackControl): boolean {
  if (event.ctrlKey || event.metaKey || event.altKey || !control.playback.whole) return false;
  const target = event.target instanceof Element ? event.target : undefined;
  switch (event.key) {
    case " ": if (target?.closest("button, select") != null) return false; control.toggle(); break;
    case "k": case "K": control.toggle(); break;
    case "j": case "J": control.jump(-1); break;
    case "l": case "L": control.jump(1); break;
    default: return false;
  }
  event.preventDefault();
  return true;
}
