import { useEffect, useMemo, useState } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Anatomy } from "../../api/tooth_number";
import { formatMoment } from "../../base/format";
import { say } from "../../base/words";
import type { AngledView } from "../../tooth/messages";
import { ErrorNotice, Loading } from "../../widgets/basics";
import { angledFrom } from "../../widgets/tooth/angled";
import { TissueLegend } from "../../widgets/tooth/legend";
import { ToothView } from "../../widgets/tooth/tooth_view";
import { useWorkFilm, type WorkFilm } from "./use_work_film";

interface Props {
  readonly client: Client;
  readonly work: string;
  readonly name: string; // what the work is called here
  readonly anatomy: Anatomy | undefined;
}

// The tooth of a work, at its end or while it was cut.
export function WorkTooth({ client, work, name, anatomy }: Props) {
  const found = useWorkFilm(client, work);
  if (found.state === "loading") return <Loading what={say("loading.picture")} />;
  if (found.state === "waits") return <Loading what={found.message} />;
  if (found.state === "failed")
    return <ErrorNotice title={say("marking.no_picture")} message={found.message} onRetry={found.again} />;
  return <Shown work={found.value} name={name} anatomy={anatomy} />;
}

function Shown({
  work: { film, head, drawn, tissues },
  name,
  anatomy,
}: {
  readonly work: WorkFilm;
  readonly name: string;
  readonly anatomy: Anatomy | undefined;
}) {
  const cut = head?.cut;
  const angled = useMemo(
    (): AngledView => ({
      direction: angledFrom(anatomy?.mesial),
      centre: cut?.centreMm,
      cavity: cut,
    }),
    [anatomy, cut],
  );
  const frames = head?.frames ?? 0;
  const [moment, setMoment] = useState(frames);
  useEffect(() => setMoment(frames), [frames]);
  if (head === undefined) return <Loading what={say("loading.picture")} />;
  const time = formatMoment((moment * head.frameTicks) / head.rateHz);
  return (
    <>
      <ToothView film={film} anatomy={anatomy} busy={!drawn} mode="tissue" angled={angled} label={name} name={name} />
      <div class="work-moment">
        <label>
          <span>{say("marking.moment")}</span>
          <input
            type="range"
            min={0}
            max={frames}
            value={moment}
            aria-valuetext={moment === frames ? say("marking.at_end") : time}
            onInput={(event) => {
              const frame = Number(event.currentTarget.value);
              setMoment(frame);
              film.seek(frame);
            }}
          />
        </label>
        <span class="work-time">{moment === frames ? say("marking.at_end") : time}</span>
      </div>
      <TissueLegend tissues={tissues} />
    </>
  );
}
