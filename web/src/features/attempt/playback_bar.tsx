import { useMemo } from "preact/hooks";
import { formatMoment, formatNumber } from "../../base/format";
import { type Gap, gapsOf } from "./clock";
import type { PlaybackControl } from "./use_playback";

// Play, pause, speed, what is played again, and the moment of the tooth's picture.
export function PlaybackBar({ control }: { readonly control: PlaybackControl }) {
  const { playback, clock, playing, speed, speeds, loop } = control;
  const { state, head } = playback;
  const gaps = useMemo(() => head === undefined || !playback.whole ? [] : gapsOf(head, playback.poses), [playback, head, playback.whole]);
  if (state.state === "waiting") return <p class="hint" role="status">{waitingText}</p>;
  if (state.state === "failed") return <p class="hint" role="status">The attempt cannot be played back: {state.error.message}</p>;
  if (state.state === "loading" || !playback.whole || clock === undefined) return <p class="hint" role="status">Loading the playback…</p>;
  if (playback.frames === 0) return null;
  const time = (frames: number) => formatMoment(clock.timeOf(frames));
  const share = (frames: number) => `${100 * frames / playback.frames}%`;
  return (
    <div class="playback no-print" role="group" aria-label="Playback" data-shown={playback.position}>
      <button type="button" class="button small" aria-label="One frame back" title="One frame back (,)" onClick={() => control.step(-1)}>‹</button>
      <button type="button" class="button small playback-play" title="Play and pause (K or Space)" onClick={control.toggle}>{playing ? "Pause" : "Play"}</button>
      <button type="button" class="button small" aria-label="One frame on" title="One frame on (.)" onClick={() => control.step(1)}>›</button>
      <span class="playback-slider">
        <input type="range" min={0} max={playback.frames} step={1} value={playback.position} aria-label="Playback position"
               aria-valuetext={`${time(playback.position)} of ${time(playback.frames)}`} onInput={(event) => control.show(Number(event.currentTarget.value))} />
        {gaps.map((gap) => <span key={gap.frames} class="playback-gap" style={{ left: share(gap.frames) }} title={gapText(gap)} />)}
        {loop !== undefined && <span class="playback-loop" style={{ left: share(loop.from), right: loop.to === undefined ? "0" : `calc(100% - ${share(loop.to)})` }} />}
      </span>
      <span class="playback-time">{time(playback.position)}</span>
      <span class="button-row playback-ab">
        <button type="button" class="button small quiet" aria-label="Play again from here" title="Play again from here ([)" aria-pressed={loop !== undefined} onClick={control.loopFrom}>A</button>
        <button type="button" class="button small quiet" aria-label="Play again up to here" title="Play again up to here (])" aria-pressed={loop?.to !== undefined} onClick={control.loopTo}>B</button>
        {loop !== undefined && <button type="button" class="button small quiet" aria-label="Play all" title="Play all (\)" onClick={control.loopOff}>×</button>}
      </span>
      <label class="playback-speed"><span class="hidden">Speed</span>
        <select value={speed} title="Slower (−), faster (+)" onChange={(event) => control.setSpeed(Number(event.currentTarget.value))}>
          {speeds.map((value) => <option key={value} value={value}>{`${value}×`}</option>)}
        </select>
      </label>
      {gaps.length > 0 && <span class="hidden">Not recorded: {gaps.map((gap) => `${gapText(gap)} at ${time(gap.frames)}`).join(", ")}</span>}
      {loop !== undefined && <span class="hidden" role="status">{loop.to === undefined ? `Played again from ${time(loop.from)}; choose where to` : `Played again from ${time(loop.from)} to ${time(loop.to)}`}</span>}
    </div>
  );
}

const gapText = ({ seconds }: Gap) => `${formatNumber(seconds, 2)} s not recorded`;

const waitingText = "The playback of this attempt is being made. It shows here by itself in a few minutes.";
