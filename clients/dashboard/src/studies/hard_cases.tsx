import { Title } from "../app/title";

export function HardCases() {
  return <Title text="HardCases" />;
}
