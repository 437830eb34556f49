import { useEffect, useRef, useState } from "preact/hooks";
import { downloadFile } from "../../base/download";
import { say } from "../../base/words";
import { useMoves } from "./use_moves";
import type { PlaybackControl } from "./use_playback";

// The playback as a video (WebM), made by the browser from the picture as it is looked at: the file has what was seen.

const kTypes = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"] as const;
const kBitsPerS = 4_000_000;
const kPieceMs = 500;

interface Props {
  readonly control: PlaybackControl;
  readonly picture: () => MediaStream | undefined; // undefined: there is none now
  readonly fileName: string; // without its ending
}

// Plays the attempt from the beginning, at the chosen speed, and saves what was seen until it ends or is paused.
export function VideoButton({ control, picture, fileName }: Props) {
  const [recorder, setRecorder] = useState<MediaRecorder>();
  const [failed, setFailed] = useState(false);
  const begun = useRef(false); // it has played since
  const latest = useRef({ control, fileName });
  latest.current = { control, fileName };

  useEffect(() => {
    if (recorder === undefined) return undefined;
    const pieces: Blob[] = [];
    recorder.ondataavailable = ({ data }) => pieces.push(data);
    recorder.onerror = () => setFailed(true);
    recorder.onstop = () => {
      setRecorder(undefined);
      if (pieces.some(({ size }) => size > 0)) void save(latest.current.fileName, pieces, recorder.mimeType);
      else setFailed(true);
    };
    begun.current = false;
    latest.current.control.show(0);
    recorder.start(kPieceMs);
    latest.current.control.toggle();
    return () => {
      recorder.onstop = null; // somebody has left the page
      if (recorder.state !== "inactive") recorder.stop();
      for (const track of recorder.stream.getTracks()) track.stop();
    };
  }, [recorder]);

  useMoves(control.playback);
  // Paused, or at the end: then once the end is drawn.
  const { wanted, position, frames } = control.playback;
  const over = !control.playing && (wanted < frames || position === frames);
  useEffect(() => {
    if (control.playing) begun.current = true;
    else if (begun.current && over && recorder?.state === "recording") recorder.stop();
  }, [control.playing, over, recorder]);

  const record = () => {
    const stream = picture();
    const type =
      typeof MediaRecorder === "undefined" ? undefined : kTypes.find((each) => MediaRecorder.isTypeSupported(each));
    setFailed(stream === undefined || type === undefined);
    if (stream === undefined || type === undefined) return;
    setRecorder(new MediaRecorder(stream, { mimeType: type, videoBitsPerSecond: kBitsPerS }));
  };
  return (
    <>
      <button
        type="button"
        class="button small quiet"
        title={say("video.hint")}
        aria-pressed={recorder !== undefined}
        onClick={() => (recorder === undefined ? record() : recorder.stop())}
      >
        {say(recorder === undefined ? "video.save" : "video.stop")}
      </button>
      {recorder !== undefined && <span role="status">{say("video.recording")}</span>}
      {failed && <span role="alert">{say("video.failed")}</span>}
    </>
  );
}

async function save(name: string, pieces: readonly Blob[], type: string): Promise<void> {
  downloadFile(`${name}.webm`, type, await new Blob([...pieces], { type }).arrayBuffer());
}
