"""`exoid identify` in a campaign: the numbers of a model."""

from exoid.apps.campaign.verb import CampaignVerb

VERB = CampaignVerb()
