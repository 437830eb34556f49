import { useMemo } from "preact/hooks";
import type { Client } from "../../api/client";
import type { Surface } from "../../api/surface";
import { type Anatomy, anatomyOf, toScene } from "../../api/tooth_number";
import type { Exercise } from "../../api/types";
import { useRequest } from "../../api/use_request";
import { say } from "../../base/words";
import { Card, ErrorNotice, Loading } from "../../widgets/basics";
import { TissueLegend } from "../../widgets/tooth/legend";
import type { AngledView, PointMm } from "../../widgets/tooth/scene";
import { tissuesPresent, tissueTitle, workpiece } from "../../widgets/tooth/tissue";
import { ToothView } from "../../widgets/tooth/tooth_view";

const kDirection = [0.5, -0.6, 0.9] as const; // with mesial at +x
const kFromTop = 0.35; // of the tooth's height: the work is at the crown, not in the middle of the roots

// What one will find at the station: the tooth or block before anything is cut.
export function InitialTooth({ client, exercise }: { readonly client: Client; readonly exercise: Exercise }) {
  const { loaded, reload } = useRequest(exercise.scene_sha256 + exercise.id, (signal) =>
    client.teaching.initialSurface(exercise.id, signal),
  );
  return (
    <Card title={say("exercise_page.before")} className="tooth-card">
      {loaded.state === "loading" && <Loading what={say("loading.picture")} />}
      {loaded.state === "failed" && (
        <ErrorNotice title={say("exercise_page.picture_failed")} message={loaded.error.message} onRetry={reload} />
      )}
      {loaded.state === "ready" && <Tooth surface={loaded.value} target={exercise.target} />}
    </Card>
  );
}

function Tooth({ surface, target }: { readonly surface: Surface; readonly target: Exercise["target"] }) {
  const tissues = useMemo(() => tissuesPresent(surface.tissue), [surface]);
  const anatomy = useMemo((): Anatomy => anatomyOf(target), [target]);
  const angled = useMemo(
    (): AngledView => ({
      direction: [kDirection[0] * anatomy.mesial, kDirection[1], kDirection[2]],
      centre: crownOf(surface, anatomy),
    }),
    [surface, anatomy],
  );
  return (
    <>
      <ToothView
        model={{ surface }}
        anatomy={anatomy}
        mode="tissue"
        angled={angled}
        label={say(`exercise_page.shows_${workpiece(tissues)}`, { tissues: tissues.map(tissueTitle).join(", ") })}
      />
      <TissueLegend tissues={tissues} />
    </>
  );
}

function crownOf({ positionMm }: Surface, anatomy: Anatomy): PointMm {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positionMm.length; ++i) {
    low[i % 3] = Math.min(low[i % 3]!, positionMm[i]!);
    high[i % 3] = Math.max(high[i % 3]!, positionMm[i]!);
  }
  const occlusal = toScene(anatomy, [0, 0, 1]);
  const along = (axis: 0 | 1 | 2) =>
    (low[axis]! + high[axis]!) / 2 + (0.5 - kFromTop) * (high[axis]! - low[axis]!) * occlusal[axis];
  return [along(0), along(1), along(2)];
}
