import { Notice } from "../../widgets/basics";
import { CopyText } from "../../widgets/copy";

// A password that the server made up. It is shown this once and is kept nowhere.
export function OneTimePassword({ login, password, onClose }: { readonly login: string; readonly password: string; readonly onClose: () => void }) {
  return (
    <>
      <p>Login: <code>{login}</code></p>
      <div class="secret"><CopyText text={password} what="the password" /></div>
      <Notice tone="warning" title="Shown only now">
        <p>Give it to the person in private. Whoever signs in with it has to choose a new password.</p>
      </Notice>
      <div class="button-row end"><button type="button" class="button primary" onClick={onClose}>I have noted it</button></div>
    </>
  );
}
