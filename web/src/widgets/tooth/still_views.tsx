import { useEffect, useRef, useState } from "preact/hooks";
import type { Anatomy } from "../../api/tooth_number";
import { say } from "../../base/words";
import { studio } from "../../tooth/link";
import type { ToothPlan } from "../../tooth/messages";
import { kStillSides, stillPlane } from "./still_planes";

const kEnamel = [255, 250, 238] as const; // fully lit

// A tooth from five sides, for a browser without WebGL: drawn once, by the worker's processor. `bytes`: its surface.
export function StillViews({ bytes, anatomy }: { readonly bytes: ArrayBuffer; readonly anatomy: Anatomy }) {
  const [plans, setPlans] = useState<readonly ToothPlan[]>([]);
  useEffect(() => {
    let shown = true;
    void drawn(bytes, anatomy).then((made) => {
      if (shown) setPlans(made);
    });
    return () => {
      shown = false;
    };
  }, [bytes, anatomy]);
  return (
    <div class="still-views">
      {plans.map((plan, i) => (
        <figure key={kStillSides[i]!.side}>
          <StillView plan={plan} label={say(`view.${kStillSides[i]!.side}`)} />
          <figcaption aria-hidden="true">{say(`view.${kStillSides[i]!.side}`)}</figcaption>
        </figure>
      ))}
    </div>
  );
}

async function drawn(bytes: ArrayBuffer, anatomy: Anatomy): Promise<readonly ToothPlan[]> {
  const film = studio().film(() => undefined);
  const planes = kStillSides.map(({ towards, up }) => stillPlane(anatomy, towards, up));
  const plans = await film.plans(bytes.slice(0), planes);
  film.close();
  return plans.ok ? plans.value : [];
}

function StillView({ plan, label }: { readonly plan: ToothPlan; readonly label: string }) {
  const element = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const context = element.current?.getContext("2d");
    if (context == null) return;
    const { shade, width, height } = plan;
    const pixels = context.createImageData(width, height);
    shade.forEach((light, i) => {
      for (let channel = 0; channel < 3; channel++) pixels.data[4 * i + channel] = (kEnamel[channel]! * light) / 255;
      pixels.data[4 * i + 3] = light === 0 ? 0 : 255;
    });
    context.putImageData(pixels, 0, 0);
  }, [plan]);
  return <canvas ref={element} width={plan.width} height={plan.height} role="img" aria-label={label} />;
}
