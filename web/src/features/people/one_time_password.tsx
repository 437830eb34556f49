import { Notice } from "../../widgets/basics";
import { CopyText } from "../../widgets/copy";

// A password that the server made up. It is shown this once and is kept nowhere.
export function OneTimePassword({ login, password, onClose }: { readonly login: string; readonly password: string; readonly onClose: () => void }) {
  return (
    <>
      <p>Login: <code>{login}</code></p>
      <div class="secret"><CopyText text={password} what="the password" /></div>
      <Notice tone="warning" title="Shown only now">
        <p>Give it to the person in private. At the first sign-in a password of one's own has to be chosen.</p>
      </Notice>
      <div class="button-row end"><button type="button" class="button primary" onClick={onClose}>I have noted it</button></div>
    </>
  );
}
