import { formatDateTime } from "../../base/format";
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
      <p>Login: <code>{login}</code></p>
      <div class="secret"><CopyText text={password} what="the password" /></div>
      <Notice tone="warning" title="Shown only now">
        <p>Give it to the person in private. It is good for signing in once, until {formatDateTime(untilMs)}; whoever does has to choose a new password.</p>
      </Notice>
      <div class="button-row end"><button type="button" class="button primary" onClick={onClose}>I have noted it</button></div>
    </>
  );
}
