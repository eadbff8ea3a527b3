import { Title } from "../app/title";

export function Now() {
  return <Title text="Now" />;
}
