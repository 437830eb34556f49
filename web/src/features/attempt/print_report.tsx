import { useEffect, useRef, useState } from "preact/hooks";
import { say } from "../../base/words";
import type { CameraPreset } from "../../tooth/messages";
import type { LookHandle } from "../../widgets/tooth/tooth_view";

// The report on paper: the page's print style, with the tooth from set sides, so that reports can be laid side by side.

const kSides: readonly CameraPreset[] = ["occlusal", "buccal", "lingual", "mesial", "distal"];

interface Side {
  readonly side: CameraPreset;
  readonly address: string; // of the picture
}

// Prints the page, with pictures that are made first. `look`: of the tooth that is shown; undefined: none is.
export function PrintButton({
  look,
  quiet = false,
}: {
  readonly look: () => LookHandle | undefined;
  readonly quiet?: boolean;
}) {
  const [busy, setBusy] = useState(false);
  const [sides, setSides] = useState<readonly Side[]>([]);
  const shown = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (sides.length === 0) return undefined;
    const images = [...(shown.current?.querySelectorAll("img") ?? [])];
    void Promise.allSettled(images.map((image) => image.decode())).then(() => window.print());
    const done = () => setSides([]); // another moment has other pictures
    window.addEventListener("afterprint", done);
    return () => {
      window.removeEventListener("afterprint", done);
      for (const { address } of sides) URL.revokeObjectURL(address);
    };
  }, [sides]);
  const print = async () => {
    setBusy(true);
    const pictures = await picturesOf(look());
    setBusy(false);
    if (pictures.length > 0) setSides(pictures);
    else window.print();
  };
  return (
    <>
      <button
        type="button"
        class={quiet ? "button small quiet" : "button print-button"}
        disabled={busy}
        onClick={() => void print()}
      >
        {say(busy ? "attempt.printing" : "attempt.print")}
      </button>
      {sides.length > 0 && (
        <div class="set-sides" ref={shown}>
          {sides.map(({ side, address }) => (
            <figure key={side}>
              <img src={address} alt={say("attempt.from_side", { side: say(`view.${side}`) })} />
              <figcaption>{say(`view.${side}`)}</figcaption>
            </figure>
          ))}
        </div>
      )}
    </>
  );
}

async function picturesOf(look: LookHandle | undefined): Promise<Side[]> {
  const out: Side[] = [];
  for (const side of kSides) {
    const png = await look?.pictureFrom?.(side);
    if (png !== undefined) out.push({ side, address: URL.createObjectURL(png) });
  }
  return out;
}
