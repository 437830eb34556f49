import { formatSigned } from "../../base/format";
import { say } from "../../base/words";
import type { DeviationSummary } from "./deviation";

interface Props {
  readonly summary: DeviationSummary;
  readonly said: string; // all of it in a sentence
}

// The deviation by side.
export function DeviationFigures({ summary, said }: Props) {
  return (
    <>
      <p>{said}</p>
      <table>
        <caption class="hidden">{say("tooth_card.by_side")}</caption>
        <thead>
          <tr>
            <th scope="col">{say("tooth_card.side")}</th>
            <th scope="col" class="number">
              {say("tooth_card.mean")}
            </th>
            <th scope="col" class="number">
              {say("tooth_card.largest")}
            </th>
          </tr>
        </thead>
        <tbody>
          {summary.sides.map((side) => (
            <tr key={side.side}>
              <th scope="row">{say(`cavity_side.${side.side}`)}</th>
              <td class="number">{formatSigned(side.meanMm)}</td>
              <td class="number">{formatSigned(side.mostMm)}</td>
            </tr>
          ))}
        </tbody>
      </table>
      <p class="hint">{say("tooth_card.plus")}</p>
    </>
  );
}
