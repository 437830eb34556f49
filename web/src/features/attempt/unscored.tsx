import type { AttemptDetail } from "../../api/types";
import { unreachable } from "../../base/assert";
import { sentence } from "../../base/format";
import { say, sayIf } from "../../base/words";
import { Notice, Progress } from "../../widgets/basics";

interface Props {
  readonly attempt: AttemptDetail;
}

// Why the server could not score it.
export function Problem({ attempt }: Props) {
  return <p>{sayIf(`refusal.${attempt.problem_field}`) ?? sentence(attempt.problem)}</p>;
}

// What has no score, or not yet.
export function Unscored({ attempt }: Props) {
  switch (attempt.state) {
    case "ticketed":
      return <p>{say("attempt.not_begun")}</p>;
    case "recording":
      return <Progress label={say("attempt.recording")} share={undefined} />;
    case "sealed":
      return <Progress label={say("attempt_state.sealed")} share={undefined} />;
    case "scoring":
      return <Progress label={say("attempt.scoring")} share={attempt.progress} />;
    case "failed":
      return (
        <Notice tone="bad" title={say("attempt.not_scored")}>
          <Problem attempt={attempt} />
        </Notice>
      );
    case "quarantined":
      return (
        <Notice tone="bad" title={say("attempt.set_aside")}>
          <Problem attempt={attempt} />
          <p>{say("attempt.set_aside_text")}</p>
        </Notice>
      );
    case "scored":
      return null;
    default:
      return unreachable(attempt.state);
  }
}
