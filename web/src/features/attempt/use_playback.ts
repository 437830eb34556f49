import { useEffect, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import { say } from "../../base/words";
import type { Key } from "../../widgets/keys";
import { prepareTooth } from "../../widgets/tooth/tooth_view";
import { FrameClock } from "./clock";
import { type Playback, playbackOf } from "./playback";

const kAskAgainMs = 5000;
const kTellMs = 250; // the plots follow four times a second
const kSpeeds = [0.1, 0.25, 0.5, 1, 2, 4, 8, 16] as const;
const kJumpS = 5;

// What is played again and again, in frames.
export interface Loop {
  readonly from: number;
  readonly to: number | undefined; // undefined: its end is still to be chosen
}

export interface PlaybackControl {
  readonly playback: Playback;
  readonly clock: FrameClock | undefined;
  readonly speeds: readonly number[];
  readonly held: number | undefined; // frames of the moment, while the tooth stays as it is at its end
  readonly playing: boolean;
  readonly speed: number;
  readonly loop: Loop | undefined;
  readonly toggle: () => void;
  readonly setSpeed: (speed: number) => void;
  readonly show: (frames: number) => void;
  readonly step: (frames: number) => void;
  readonly jump: (direction: -1 | 1) => void;
  readonly loopFrom: () => void;
  readonly loopTo: () => void;
  readonly loopOff: () => void;
}

// Plays an attempt back, with the moment of the page's plots. `made`: another text means another
// playback, such as one of a new score. Undefined: there is no recording.
export function usePlayback(
  client: Client,
  attempt: string | undefined,
  made: string,
  timeS: number | undefined,
  setTime: (timeS: number) => void,
  heldS: number | undefined, // at this moment the tooth stays as it is at its end
): PlaybackControl | undefined {
  const [changes, redraw] = useState(0);
  const playback = useMemo(
    () => (attempt === undefined ? undefined : playbackOf(client, attempt, () => redraw((n) => n + 1))),
    [client, attempt, made],
  );
  const [playing, setPlaying] = useState(false);
  const [speed, setSpeed] = useState(1);
  const [loop, setLoop] = useState<Loop>();
  // Which run of the playback it is: a frame that was asked for before somebody chose another
  // moment must not undo that.
  const run = useRef(0);
  const stop = useMemo(
    () => () => {
      ++run.current;
      setPlaying(false);
    },
    [],
  );
  const ownTime = useRef<number | undefined>(undefined); // that this told

  useEffect(() => {
    setPlaying(false);
    setLoop(undefined);
    if (playback === undefined) return undefined;
    prepareTooth();
    void playback.load();
    return () => playback.dispose();
  }, [playback]);

  // Of the same playback: it waits until the answer is there, so that the picture without one stays, which has megabytes.
  const state = playback?.state;
  useEffect(() => {
    if (state?.state !== "waiting") return undefined;
    const timer = setTimeout(() => void playback?.load(), kAskAgainMs);
    return () => clearTimeout(timer);
  }, [playback, state]);

  const ready = playback?.state.state === "ready";
  const head = playback?.head;
  const clock = useMemo(
    () => (playback === undefined || head === undefined ? undefined : new FrameClock(head, playback.gaps)),
    [playback, head, playback?.whole],
  );
  const latest = useRef({ clock, loop, setTime });
  latest.current = { clock, loop, setTime };

  // A moment that is set elsewhere moves the tooth. At once: where pictures take long, playing would tell of the next
  // moment before this one is looked at, and would be stopped by its own news.
  useLayoutEffect(() => {
    if (playback === undefined || clock === undefined || !ready || timeS === undefined || timeS === ownTime.current)
      return;
    ownTime.current = timeS;
    stop();
    playback.show(timeS === heldS ? playback.frames : clock.framesAt(timeS));
  }, [playback, ready, clock, timeS, heldS, stop]);

  const tell = useMemo(
    () => (frames: number) => {
      const at = latest.current.clock?.timeOf(frames);
      if (at === undefined || at === ownTime.current) return;
      ownTime.current = at;
      latest.current.setTime(at);
    },
    [],
  );

  const held =
    clock !== undefined && playback?.whole === true && timeS !== undefined && timeS === heldS
      ? clock.framesAt(timeS)
      : undefined;
  const rate = head === undefined ? 10 : head.rateHz / head.frameTicks;
  useEffect(() => {
    if (!playing || playback === undefined) return undefined;
    let at =
      playback.position >= endOf(playback, latest.current.loop) ? (latest.current.loop?.from ?? 0) : playback.position;
    let before: number | undefined;
    let told = 0;
    const own = ++run.current;
    let handle = requestAnimationFrame(function next(now) {
      if (own !== run.current) return;
      const end = endOf(playback, latest.current.loop);
      at += ((now - (before ?? now)) / 1000) * rate * speed;
      before = now;
      const again = latest.current.loop?.to !== undefined;
      if (at >= end) at = again ? (latest.current.loop?.from ?? 0) : end;
      playback.show(Math.floor(at));
      const ended = at >= end;
      if (ended || now - told > kTellMs) {
        told = now;
        tell(Math.floor(at));
      }
      if (ended) setPlaying(false);
      else handle = requestAnimationFrame(next);
    });
    return () => cancelAnimationFrame(handle);
  }, [playing, playback, speed, rate, tell]);

  return useMemo(() => {
    if (playback === undefined) return undefined;
    const show = (frames: number) => {
      const wanted = Math.max(0, Math.min(Math.round(frames), playback.frames));
      stop();
      playback.show(wanted);
      tell(wanted);
    };
    return {
      playback,
      clock,
      held,
      playing,
      speed,
      setSpeed,
      show,
      loop,
      speeds: kSpeeds,
      toggle: () => setPlaying((was) => !was && ready),
      step: (frames) => show(playback.wanted + frames),
      jump: (direction) => show(playback.wanted + direction * kJumpS * rate),
      loopFrom: () =>
        setLoop((was) => ({
          from: playback.wanted,
          to: was?.to !== undefined && was.to > playback.wanted ? was.to : undefined,
        })),
      loopTo: () =>
        setLoop((was) =>
          was !== undefined && playback.wanted > was.from
            ? { from: was.from, to: playback.wanted }
            : { from: 0, to: Math.max(playback.wanted, 1) },
        ),
      loopOff: () => setLoop(undefined),
    };
  }, [playback, clock, held, playing, speed, loop, ready, rate, changes, stop, tell]);
}

// The frame at which playing ends or begins again.
function endOf(playback: Playback, loop: Loop | undefined): number {
  return loop?.to ?? playback.frames;
}

// The playback's keys. They act on whatever `control` is when they are pressed.
export function playbackKeys(control: () => PlaybackControl | undefined): Key[] {
  const on = (act: (control: PlaybackControl) => void) => () => {
    const now = control();
    if (now?.playback.whole === true) act(now);
  };
  const faster = (by: 1 | -1) =>
    on((now) =>
      now.setSpeed(kSpeeds[Math.max(0, Math.min(kSpeeds.indexOf(now.speed as 1) + by, kSpeeds.length - 1))]!),
    );
  return [
    { key: "k", also: " ", what: say("playback.key_play"), act: on((now) => now.toggle()) },
    { key: "j", what: say("playback.key_back"), act: on((now) => now.jump(-1)) },
    { key: "l", what: say("playback.key_on"), act: on((now) => now.jump(1)) },
    { key: ",", also: "ArrowLeft", what: say("playback.frame_back"), act: on((now) => now.step(-1)) },
    { key: ".", also: "ArrowRight", what: say("playback.frame_on"), act: on((now) => now.step(1)) },
    { key: "Home", what: say("playback.key_begin"), act: on((now) => now.show(0)) },
    { key: "End", what: say("playback.key_end"), act: on((now) => now.show(now.playback.frames)) },
    { key: "-", what: say("playback.slower"), act: faster(-1) },
    { key: "+", what: say("playback.faster"), act: faster(1) },
    { key: "[", what: say("playback.key_a"), act: on((now) => now.loopFrom()) },
    { key: "]", what: say("playback.key_b"), act: on((now) => now.loopTo()) },
    { key: "\\", what: say("playback.all"), act: on((now) => now.loopOff()) },
  ];
}
