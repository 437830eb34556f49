import { type ComponentChild, Component, createElement } from "preact";

// A component that is drawn again only when something that it is given has changed. For what does not follow the
// moment of a playback: dozens of moments a second are shown.
export function still<Props extends object>(part: (props: Props) => ComponentChild) {
  return class Still extends Component<Props> {
    override shouldComponentUpdate(next: Readonly<Props>): boolean {
      return differ(this.props, next);
    }
    override render() {
      return createElement(part, this.props);
    }
  };
}

function differ(was: object, now: object): boolean {
  const [before, after] = [Object.entries(was), Object.entries(now)];
  return (
    before.length !== after.length || after.some(([key, value]) => (was as Record<string, unknown>)[key] !== value)
  );
}
