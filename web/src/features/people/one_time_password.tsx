import { formatDateTime } from "../../base/format";
import { say, sayWith } from "../../base/words";
import { Notice } from "../../widgets/basics";
import { CopyText } from "../../widgets/copy";

interface Props {
  readonly login: string;
  readonly password: string;
  readonly untilMs: number;
  readonly onClose: () => void;
}

// A password that the server made up. It is shown this once and is kept nowhere.
export function OneTimePassword({ login, password, untilMs, onClose }: Props) {
  return (
    <>
      <p>{sayWith("one_time.login", { login: <code>{login}</code> })}</p>
      <div class="secret">
        <CopyText text={password} what={say("copy.password")} />
      </div>
      <Notice tone="warning" title={say("common.shown_now")}>
        <p>{say("one_time.give", { until: formatDateTime(untilMs) })}</p>
      </Notice>
      <div class="button-row end">
        <button type="button" class="button primary" onClick={onClose}>
          {say("one_time.noted")}
        </button>
      </div>
    </>
  );
}
