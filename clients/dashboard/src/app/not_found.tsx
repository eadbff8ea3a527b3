import { Title } from "./title";

export function NotFound() {
  return (
    <>
      <Title text="Nothing here" />
      <p>
        There is no page at this address. <a href="/">What the daemon does now</a> is a good place to begin.
      </p>
    </>
  );
}
