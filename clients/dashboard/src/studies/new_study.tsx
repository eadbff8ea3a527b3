import { Title } from "../app/title";

export function NewStudy() {
  return <Title text="NewStudy" />;
}
